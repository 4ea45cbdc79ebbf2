import assert from "node:assert/strict";
import test from "node:test";

import { Stick, deflection, velocity } from "../../../workbench/link/page/sticks.js";

const LIMITS = { level_speed: 8, climb_rate: 3, yaw_rate: 0.4 };
const REST = { x: 0, y: 0 };

function near(found, expected) {
  found.forEach((each, i) => assert.ok(Math.abs(each - expected[i]) < 0.01, `${found}: ${expected}`));
}

test("a resting finger asks for nothing, one beyond the rim for no more than all", () => {
  assert.deepEqual(deflection(2, -2, 60), REST);
  const { x, y } = deflection(300, -400, 60);
  near([x, y], [0.6, 0.8]);
  assert.ok(Math.hypot(x, y) <= 1 + 1e-12);
});

test("up on the screen is up", () => {
  assert.ok(deflection(0, -30, 60).y > 0.4);
  assert.deepEqual(deflection(0, 0, 0), REST);
});

test("ahead and aside are the drone's, turned into W", () => {
  const ahead = { x: 0, y: 1 };
  const right = { x: 1, y: 0 };
  near(velocity(REST, ahead, 0, 2, LIMITS).v, [2, 0, 0]);
  near(velocity(REST, ahead, Math.PI / 2, 2, LIMITS).v, [0, 2, 0]);
  near(velocity(REST, right, 0, 2, LIMITS).v, [0, -2, 0]);
  near(velocity(REST, right, Math.PI / 2, 2, LIMITS).v, [2, 0, 0]);
});

test("the left stick climbs and turns to the right", () => {
  const { v, yawRate } = velocity({ x: 1, y: -1 }, REST, 1, 1, LIMITS);
  near([...v, yawRate], [0, 0, -1, -0.4]);
});

test("no limit is exceeded, even in 32 bits", () => {
  for (let degree = 0; degree < 360; degree += 7) {
    const stick = { x: Math.sin(degree), y: Math.cos(degree) };
    const { v, yawRate } = velocity(stick, stick, degree, 100, LIMITS);
    const [x, y, z] = v.map(Math.fround);
    assert.ok(Math.hypot(x, y) <= 8 && Math.abs(z) <= 3 && Math.abs(yawRate) <= 0.4);
  }
});

test("neutral sticks ask for plain zeros", () => {
  const { v, yawRate } = velocity(REST, REST, 2, 4, LIMITS);
  assert.ok([...v, yawRate].every((each) => each === 0));
});

/** An element that is listened to. */
class Pad extends EventTarget {
  clientWidth = 160;
  captured = null;
  classList = { toggle() {} };
  setPointerCapture(id) {
    this.captured = id;
  }
  fire(type, fields) {
    const event = new Event(type, { cancelable: true });
    this.dispatchEvent(Object.assign(event, { button: 0, pointerId: 1, clientX: 0, clientY: 0 }, fields));
  }
}

function made() {
  const pad = new Pad();
  const knob = { clientWidth: 40, style: {} };
  return { pad, knob, stick: new Stick(pad, knob) };
}

test("a touch is neutral where it begins, and moves the knob no further than the rim", () => {
  const { pad, knob, stick } = made();
  pad.fire("pointerdown", { clientX: 150, clientY: 20 });
  assert.deepEqual(stick.value, REST);
  assert.equal(pad.captured, 1);
  pad.fire("pointermove", { clientX: 150, clientY: -500 });
  near([stick.value.x, stick.value.y], [0, 1]);
  assert.equal(knob.style.transform, "translate(0px, -60px)");
});

for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
  test(`${end} springs the stick back`, () => {
    const { pad, knob, stick } = made();
    pad.fire("pointerdown");
    pad.fire("pointermove", { clientX: 60 });
    assert.notDeepEqual(stick.value, REST);
    pad.fire(end);
    assert.deepEqual(stick.value, REST);
    assert.match(knob.style.transform, /translate\(-?0px, -?0px\)/);
  });
}

test("a second finger on the same stick changes nothing", () => {
  const { pad, stick } = made();
  pad.fire("pointerdown");
  pad.fire("pointermove", { clientX: 60 });
  pad.fire("pointerdown", { pointerId: 2 });
  pad.fire("pointermove", { pointerId: 2, clientX: -60 });
  pad.fire("pointerup", { pointerId: 2 });
  near([stick.value.x], [1]);
});

test("after a release the finger counts only when it comes again", () => {
  const { pad, stick } = made();
  pad.fire("pointerdown");
  stick.release();
  pad.fire("pointermove", { clientX: 60 });
  assert.deepEqual(stick.value, REST);
  pad.fire("pointerdown");
  pad.fire("pointermove", { clientX: 60 });
  near([stick.value.x], [1]);
});

test("arrow keys move the stick while they are down", () => {
  const { pad, stick } = made();
  pad.fire("keydown", { key: "ArrowUp" });
  pad.fire("keydown", { key: "ArrowLeft" });
  near([stick.value.x, stick.value.y], [-0.707, 0.707]);
  pad.fire("keyup", { key: "ArrowUp" });
  near([stick.value.x, stick.value.y], [-1, 0]);
  pad.fire("blur");
  assert.deepEqual(stick.value, REST);
});
