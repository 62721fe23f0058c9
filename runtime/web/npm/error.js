// What every promise and method of this package fails with.

/** An error with a `kind` by who is at fault; index.d.ts lists the kinds. */
export class PelageError extends Error {
  constructor(kind, message, options) {
    super(message, options);
    this.name = "PelageError";
    this.kind = kind;
  }

  /** `error` as a PelageError: what the module threw keeps its kind, all else is a fault of this package. */
  static of(error) {
    if (error instanceof PelageError) return error;
    const known = error instanceof Error && error.name === "PelageError";
    return new PelageError(known ? error.kind : "internal", error?.message ?? String(error), { cause: error });
  }
}
