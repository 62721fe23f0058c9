// Interactive camera: mouse, touch, wheel and keys, as in the window of `pelage view`.

/** Zoom factor of a wheel step (100 px) or a press of +. */
const STEP = 1.15;
/** Drag equivalent to a press of an arrow key, in heights of the picture. */
const TURN = 0.06;
/** Height of a line, for wheels that scroll by lines, pixels. */
const LINE_PX = 16;

/**
 * Listens on `canvas`, and calls the methods of `camera`: `orbit(right, up)`, `pan(right, up)`,
 * `zoom(factor, right, up)`, `reset()`, `frameAll()`, `toggle()`. Lengths are in heights of the canvas, to the right
 * and upwards; positions are relative to its centre. Returns a function that stops listening.
 */
export function control(canvas, camera) {
  const pointers = new Map();
  const abort = new AbortController();
  const { signal } = abort;
  const touchAction = canvas.style.touchAction;
  // Otherwise, touch input scrolls the page.
  canvas.style.touchAction = "none";
  if (!canvas.hasAttribute("tabindex")) canvas.tabIndex = 0;

  const height = () => Math.max(canvas.clientHeight, 1);
  const position = (event) => {
    const box = canvas.getBoundingClientRect();
    const [middleX, middleY] = [box.left + box.width / 2, box.top + box.height / 2];
    return [(event.clientX - middleX) / height(), (middleY - event.clientY) / height()];
  };
  const middle = () => {
    const [a, b] = [...pointers.values()];
    return { at: [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2], apart: Math.hypot(a[0] - b[0], a[1] - b[1]) };
  };

  const listen = (type, listener, options) => canvas.addEventListener(type, listener, { signal, ...options });
  listen("pointerdown", (event) => {
    canvas.setPointerCapture?.(event.pointerId);
    pointers.set(event.pointerId, position(event));
    canvas.focus({ preventScroll: true });
  });
  for (const type of ["pointerup", "pointercancel", "lostpointercapture"]) {
    listen(type, (event) => pointers.delete(event.pointerId));
  }
  listen("pointermove", (event) => {
    const before = pointers.get(event.pointerId);
    if (!before) return;
    const now = position(event);
    if (pointers.size === 1) {
      pointers.set(event.pointerId, now);
      const moved = [now[0] - before[0], now[1] - before[1]];
      const sideways = event.pointerType !== "touch" && (event.buttons & 6 || event.shiftKey);
      if (sideways) camera.pan(...moved);
      else camera.orbit(...moved);
    } else if (pointers.size === 2) {
      // Two fingers pan and zoom at the same time.
      const was = middle();
      pointers.set(event.pointerId, now);
      const is = middle();
      camera.pan(is.at[0] - was.at[0], is.at[1] - was.at[1]);
      if (was.apart > 0.01 && is.apart > 0.01) camera.zoom(is.apart / was.apart, ...is.at);
    }
  });
  listen("contextmenu", (event) => event.preventDefault());
  listen("dblclick", () => camera.frameAll());
  listen(
    "wheel",
    (event) => {
      event.preventDefault();
      const px = event.deltaY * [1, LINE_PX, height()][event.deltaMode];
      // Touchpads report a pinch as wheel events with Ctrl, in small steps.
      const gain = event.ctrlKey ? 5 : 1;
      camera.zoom(STEP ** ((-px * gain) / 100), ...position(event));
    },
    { passive: false },
  );
  const keys = {
    ArrowLeft: () => camera.orbit(TURN, 0),
    ArrowRight: () => camera.orbit(-TURN, 0),
    ArrowUp: () => camera.orbit(0, -TURN),
    ArrowDown: () => camera.orbit(0, TURN),
    "+": () => camera.zoom(STEP, 0, 0),
    "=": () => camera.zoom(STEP, 0, 0),
    "-": () => camera.zoom(1 / STEP, 0, 0),
    f: () => camera.frameAll(),
    r: () => camera.reset(),
    " ": () => camera.toggle(),
  };
  listen("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    if (!Object.hasOwn(keys, key)) return;
    event.preventDefault();
    keys[key]();
  });
  return () => {
    abort.abort();
    canvas.style.touchAction = touchAction;
  };
}
