import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import test from "node:test";

import { Decoder, Topic, WireError, frameBytes } from "../../../workbench/link/page/wire.js";
import { bytes, hex, vectors } from "./vectors.js";

const PIECES = [1, 7, 1 << 18];

for (const vector of vectors("frames")) {
  test(`a stream: ${vector.name}`, () => {
    const stream = bytes(vector.hex);
    for (const size of PIECES) {
      const decoder = new Decoder(vector.largest);
      const found = [];
      let code = null;
      try {
        for (let at = 0; at < stream.length; at += size) {
          for (const frame of decoder.feed(stream.slice(at, at + size))) found.push(frame);
        }
      } catch (error) {
        assert.ok(error instanceof WireError);
        code = error.code;
      }
      assert.equal(code, vector.error);
      assert.equal(found.length, vector.frames.length);
      found.forEach((frame, i) => {
        const { t_ns, payload, ...plain } = vector.frames[i];
        const { tNs, payload: gotPayload, ...got } = frame;
        assert.deepEqual(got, plain);
        assert.equal(tNs, BigInt(t_ns));
        assert.equal(hex(gotPayload), hex(bytes(payload)));
      });
    }
  });
}

test("a frame is written as it was read", () => {
  for (const vector of vectors("frames").filter((each) => each.frames.length === 1 && !each.error)) {
    const stream = bytes(vector.hex);
    const [frame] = new Decoder().feed(stream);
    const written = frameBytes(frame);
    assert.equal(hex(written), hex(stream.slice(0, written.length)), vector.name);
  }
});

// What HELLO says of the topics, as the server writes it.
const definitions = JSON.parse(readFileSync(process.env.TOPICS, "utf8"));
const topics = new Map(definitions.map((each) => [each.id, new Topic(each)]));

for (const vector of vectors("topics")) {
  test(`topic ${vector.name}: ${vector.hex.slice(0, 12)}`, () => {
    const topic = topics.get(vector.id);
    const values = topic.unpack(bytes(vector.hex));
    assert.deepEqual(Object.keys(values), Object.keys(vector.values));
    for (const [name, value] of Object.entries(values)) same(value, vector.values[name], name);
  });
}

test("a payload of the wrong size is none", () => {
  assert.throws(() => topics.get(1).unpack(new Uint8Array(15)), WireError);
});

test("a command is packed as it is unpacked", () => {
  const command = topics.get(8);
  const values = { lease: 4294967295, axes: 15, v_x: -0.5, v_y: 2, v_z: 0.25, yaw_rate: 0.125 };
  assert.deepEqual(command.unpack(command.pack(values)), values);
});

function same(found, expected, name) {
  if (Array.isArray(found)) {
    assert.equal(found.length, expected.length);
    found.forEach((each, i) => same(each, expected[i], name));
  } else if (typeof found === "bigint") assert.equal(found, BigInt(expected), name);
  else if (typeof found === "string") assert.equal(found, expected, name);
  else assert.ok(Object.is(found + 0, number(expected) + 0), `${name}: ${found}, not ${expected}`);
}

function number(value) {
  return { nan: NaN, inf: Infinity, "-inf": -Infinity }[value] ?? Number(value);
}
