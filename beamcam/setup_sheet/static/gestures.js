// Dragging, pinching and turning the wheel over a view, by mouse, pen and fingers.
//
// A wheel zooms once the view was clicked, or with Ctrl, so that a page scrolls over it else.
const Gestures = {
  on(box, does) {
    const held = new Map();
    let moved = 0;
    const local = (event) => {
      const frame = box.getBoundingClientRect();
      return [event.clientX - frame.left - box.clientLeft, event.clientY - frame.top - box.clientTop];
    };
    box.addEventListener("pointerdown", (event) => {
      held.set(event.pointerId, local(event));
      moved = 0;
      box.focus({ preventScroll: true });
      box.setPointerCapture(event.pointerId);
    });
    box.addEventListener("pointermove", (event) => {
      const from = held.get(event.pointerId);
      if (!from) return;
      const at = local(event), dx = at[0] - from[0], dy = at[1] - from[1];
      moved += Math.hypot(dx, dy);
      if (held.size === 2) {
        const other = [...held].find(([id]) => id !== event.pointerId)[1];
        const before = Math.hypot(from[0] - other[0], from[1] - other[1]);
        const now = Math.hypot(at[0] - other[0], at[1] - other[1]);
        const middle = [(at[0] + other[0]) / 2, (at[1] + other[1]) / 2];
        if (before > 0 && now > 0) does.zoom(now / before, ...middle);
        does.move(dx / 2, dy / 2);
      } else if (event.shiftKey || event.buttons === 4) does.move(dx, dy);
      else does.drag(dx, dy);
      held.set(event.pointerId, at);
    });
    for (const name of ["pointerup", "pointercancel"]) {
      box.addEventListener(name, (event) => {
        if (held.delete(event.pointerId) && moved < 4 && name === "pointerup" && does.click) {
          does.click(...local(event));
        }
      });
    }
    box.addEventListener("wheel", (event) => {
      if (!event.ctrlKey && document.activeElement !== box) return;
      event.preventDefault();
      does.zoom(Math.exp(-event.deltaY / 400), ...local(event));
    }, { passive: false });
  },
};
