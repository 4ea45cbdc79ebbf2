import assert from "node:assert/strict";
import test from "node:test";

import { heading, horizon, nearestWords } from "../../../workbench/link/page/instruments.js";
import { SECTORS, Scan } from "../../../workbench/link/page/scan.js";

const LEVEL = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
const QUARTER = SECTORS / 4;

/** A scan of four rays, ahead, left, behind and right, at one elevation. */
function cross(elevation = 0, R_BS = LEVEL) {
  return new Scan({ azimuths: [0, Math.PI / 2, 4], elevations: [elevation, 0, 1], R_BS });
}

test("each ray falls into its sector", () => {
  const found = cross().nearest([1, 2, 3, 4], 0, 0, 5);
  assert.deepEqual([0, 1, 2, 3].map((i) => found[i * QUARTER]), [1, 2, 3, 4]);
  assert.equal(found.filter(Number.isFinite).length, 4);
});

test("no return is no obstacle, and what is too near to measure is at no distance", () => {
  const found = cross().nearest([Infinity, -Infinity, NaN, 7], 0, 0, 5);
  assert.deepEqual([0, 1, 2, 3].map((i) => found[i * QUARTER]), [Infinity, 0, Infinity, 7]);
});

test("layers follow one another, and the nearest counts", () => {
  const scan = new Scan({ azimuths: [0, Math.PI / 2, 2], elevations: [-0.1, 0.1, 2], R_BS: LEVEL });
  const found = scan.nearest([9, 6, 3, 8], 0, 0, 5);
  assert.ok(Math.abs(found[0] - 3) < 1e-9);
  assert.ok(Math.abs(found[QUARTER] - 6 * Math.cos(0.1)) < 1e-9);
});

test("a sensor that is turned on the drone is turned back", () => {
  const left = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]; // its x looks to the left
  assert.equal(cross(0, left).nearest([1, 9, 9, 9], 0, 0, 5)[QUARTER], 1);
});

test("the ground and what is far above or below do not count", () => {
  assert.ok(!Number.isFinite(Math.min(...cross(-0.5).nearest([2, 2, 2, 2], 0, 0, 1.2))));
  assert.ok(!Number.isFinite(Math.min(...cross(0.8).nearest([2, 2, 2, 2], 0, 0, 5))));
});

test("a drone that pitches down still sees the wall ahead, not the ground", () => {
  // Positive pitch looks down: the level ray ahead meets the ground at 5 m from a height of 1 m.
  const pitch = Math.asin(1 / 5);
  const found = cross().nearest([5, Infinity, Infinity, Infinity], 0, pitch, 1);
  assert.ok(!Number.isFinite(found[0]));
  const up = cross(pitch).nearest([5, Infinity, Infinity, Infinity], 0, pitch, 1);
  assert.ok(Math.abs(up[0] - 5) < 1e-9);
});

test("a drone that rolls to the right has the ground on its right", () => {
  const right = cross().nearest([9, 9, 9, 3], 0.4, 0, 1.3);
  assert.ok(!Number.isFinite(right[3 * QUARTER]));
});

test("what lies level beside a rolled drone stays beside it", () => {
  // Rolled by 0.4 to the right, the level ray to the right lies 0.4 above the drone's own plane.
  const found = cross(0.4).nearest([Infinity, Infinity, Infinity, 3], 0.4, 0, 1.3);
  assert.ok(Math.abs(found[3 * QUARTER] - 3) < 1e-9);
});

test("the nearest obstacle is told in words", () => {
  const found = new Array(SECTORS).fill(Infinity);
  assert.equal(nearestWords(found), "Nothing near");
  found[QUARTER] = 2.34;
  assert.equal(nearestWords(found), "2.3 m left");
  found[SECTORS / 2] = 0.5;
  assert.equal(nearestWords(found), "0.5 m behind");
  assert.equal(nearestWords(found.map((each) => each + 11)), "12 m behind");
  found[SECTORS - 1] = 0.4;
  assert.equal(nearestWords(found), "0.4 m ahead");
});

test("heading is a compass's: yaw 0 is east, a quarter turn to the left is north", () => {
  assert.equal(heading(0), 90);
  assert.equal(heading(Math.PI / 2), 0);
  assert.equal(heading(-Math.PI / 2), 180);
  assert.equal(heading((90.3 * Math.PI) / 180), 0);
});

test("the horizon turns against the roll and rises where the drone looks down", () => {
  assert.equal(horizon(Math.PI / 6, 0), "rotate(-30.00) translate(0 0.00)");
  assert.equal(horizon(0, Math.PI / 18), "rotate(0.00) translate(0 -16.00)");
});
