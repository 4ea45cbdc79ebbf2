import assert from "node:assert/strict";
import { createHash, createHmac } from "node:crypto";
import test from "node:test";

import { fromHex, hmac, joined, sha256, toHex } from "../../../workbench/link/page/sha256.js";

/** Return bytes that differ and repeat from run to run. */
function some(length) {
  return Uint8Array.from({ length }, (_, i) => (i * 167 + (i >> 8) * 31 + length) & 255);
}

test("SHA-256 of every length around its blocks is node's", () => {
  for (const length of [...Array(200).keys(), 1000, 65536]) {
    const bytes = some(length);
    assert.equal(toHex(sha256(bytes)), createHash("sha256").update(bytes).digest("hex"), `${length}`);
  }
});

test("HMAC with keys shorter and longer than a block is node's", () => {
  for (const length of [0, 1, 16, 32, 63, 64, 65, 200]) {
    const [key, message] = [some(length), some(3 * length + 5)];
    assert.equal(toHex(hmac(key, message)), createHmac("sha256", key).update(message).digest("hex"));
  }
});

test("hexadecimal digits go there and back", () => {
  assert.deepEqual(fromHex("00ff10"), Uint8Array.of(0, 255, 16));
  assert.equal(toHex(joined(Uint8Array.of(0, 255), Uint8Array.of(16))), "00ff10");
});
