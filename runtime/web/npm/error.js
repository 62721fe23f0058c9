// Error of every promise and method of this package.

/** An error with a `kind` for its cause; index.d.ts lists the kinds. */
export class PelageError extends Error {
  constructor(kind, message, options) {
    super(message, options);
    this.name = "PelageError";
    this.kind = kind;
  }

  /** Converts `error` to a PelageError. Errors thrown by the module keep their kind; all others are `internal`. */
  static of(error) {
    if (error instanceof PelageError) return error;
    const known = error instanceof Error && error.name === "PelageError";
    return new PelageError(known ? error.kind : "internal", error?.message ?? String(error), { cause: error });
  }
}
