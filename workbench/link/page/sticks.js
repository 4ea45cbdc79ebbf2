// Touch sticks, and the velocity that they ask for.

const DEAD = 0.06; // of the way, so that a resting finger asks for nothing
const WITHIN = 0.999; // of a limit, so that rounding never exceeds it
const KEYS = {
  ArrowUp: [0, 1],
  ArrowDown: [0, -1],
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
};

/** Return how far a stick is moved, x to the right and y up, at most 1 in length.
 *
 * Args:
 *   dx, dy: way of the finger since it came, y down as on screens [px].
 *   travel: way of the stick from its centre to its rim [px].
 */
export function deflection(dx, dy, travel) {
  const far = Math.hypot(dx, dy) / travel;
  if (!(far > DEAD)) return { x: 0, y: 0 };
  const length = (Math.min(far, 1) - DEAD) / (1 - DEAD);
  return { x: (length * dx) / (far * travel), y: (-length * dy) / (far * travel) };
}

/** Return velocity in W [m/s] and yaw rate [rad/s].
 *
 * Args:
 *   left: up climbs, right turns to the right.
 *   right: up flies ahead, right to the right, as the drone is turned.
 *   yaw: of the drone about z of W, which points up [rad].
 *   speed: at full deflection [m/s].
 *   limits: of the server: level_speed, climb_rate [m/s] and yaw_rate [rad/s].
 */
export function velocity(left, right, yaw, speed, limits) {
  const level = Math.min(speed, limits.level_speed) * WITHIN;
  const climb = Math.min(speed, limits.climb_rate) * WITHIN;
  const ahead = level * right.y;
  const aside = level * right.x;
  const cos = Math.cos(yaw);
  const sin = Math.sin(yaw);
  return {
    v: [ahead * cos + aside * sin, ahead * sin - aside * cos, climb * left.y],
    yawRate: -limits.yaw_rate * WITHIN * left.x || 0,
  };
}

/** A stick under one finger: neutral where the finger comes down, sprung back when it leaves. */
export class Stick {
  /**
   * Args:
   *   pad: the element that is touched.
   *   knob: the one that moves within it.
   */
  constructor(pad, knob) {
    Object.assign(this, { pad, knob });
    this.value = { x: 0, y: 0 };
    this.pointer = null;
    this.keys = new Set();
    pad.addEventListener("pointerdown", (event) => this.down(event));
    pad.addEventListener("pointermove", (event) => this.move(event));
    for (const name of ["pointerup", "pointercancel", "lostpointercapture"]) {
      pad.addEventListener(name, (event) => event.pointerId === this.pointer && this.release());
    }
    pad.addEventListener("keydown", (event) => this.key(event, true));
    pad.addEventListener("keyup", (event) => this.key(event, false));
    pad.addEventListener("blur", () => this.keys.size > 0 && this.release());
    pad.addEventListener("contextmenu", (event) => event.preventDefault());
  }

  /** Pixels from the centre to where the knob meets the rim. */
  get travel() {
    return (this.pad.clientWidth - this.knob.clientWidth) / 2;
  }

  down(event) {
    if (this.pointer !== null || event.button > 0) return;
    event.preventDefault();
    this.keys.clear();
    this.pointer = event.pointerId;
    this.begin = [event.clientX, event.clientY];
    this.pad.setPointerCapture(event.pointerId);
    this.show({ x: 0, y: 0 });
  }

  move(event) {
    if (event.pointerId !== this.pointer) return;
    const [x, y] = this.begin;
    this.show(deflection(event.clientX - x, event.clientY - y, this.travel));
  }

  key(event, pressed) {
    if (!(event.key in KEYS) || this.pointer !== null) return;
    event.preventDefault();
    if (event.repeat) return;
    if (pressed) this.keys.add(event.key);
    else this.keys.delete(event.key);
    const [x, y] = [...this.keys].reduce(([a, b], key) => [a + KEYS[key][0], b + KEYS[key][1]], [0, 0]);
    this.show(deflection(x, -y, 1));
  }

  /** Spring back; the finger that is down, or a key, counts no more until it comes again. */
  release() {
    if (this.pointer === null && this.keys.size === 0) return;
    this.pointer = null;
    this.keys.clear();
    this.show({ x: 0, y: 0 });
  }

  show(value) {
    this.value = value;
    const { travel } = this;
    this.knob.style.transform = `translate(${value.x * travel}px, ${-value.y * travel}px)`;
    this.pad.classList.toggle("held", this.pointer !== null || this.keys.size > 0);
  }
}
