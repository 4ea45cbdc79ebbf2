import assert from "node:assert/strict";
import test from "node:test";

import { LONGEST, plain } from "../../../workbench/link/page/text.js";

test("what acts is seen, and letters stay as they are", () => {
  for (const [text, shown] of [
    ["dh_drone", "dh_drone"],
    ["<img src=x onerror=alert(1)>", "<img src=x onerror=alert(1)>"],
    ["\x1b[2J\x9b\x00\n", "\\u001b[2J\\u009b\\u0000\\u000a"],
    ["abc\u202egpj\u2067\u200f\u2028", "abc\\u202egpj\\u2067\\u200f\\u2028"],
    ["half \ud800 a pair", "half \\ud800 a pair"],
    ["tag \u{e0041}", "tag \\u{e0041}"],
    ["می\u200cخواهم 21 °C 👩\u200d🚀", "می\u200cخواهم 21 °C 👩\u200d🚀"],
    [7, "7"],
  ]) {
    assert.equal(plain(text), shown);
  }
});

test("a long text is cut and says how long it is", () => {
  assert.equal(plain("x".repeat(LONGEST)), "x".repeat(LONGEST));
  assert.equal(plain("x".repeat(1e6)), `${"x".repeat(LONGEST)}… (1000000 characters)`);
});
