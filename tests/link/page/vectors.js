// The golden vectors beside these tests, for node.

import { readFileSync } from "node:fs";

/** Return a file of vectors; whole numbers that JavaScript would round stay as texts. */
export function vectors(name) {
  const text = readFileSync(new URL(`../vectors/${name}.json`, import.meta.url), "utf8");
  return JSON.parse(text.replace(/(: )(-?\d{16,})\b/g, '$1"$2"'));
}

/** Return the bytes of hexadecimal words, of which `7a*4096` is one. */
export function bytes(text) {
  const words = text.split(/\s+/).map((word) => {
    const [digits, count] = word.split("*");
    return digits.repeat(Number(count ?? 1));
  });
  return Uint8Array.from(Buffer.from(words.join(""), "hex"));
}

export function hex(found) {
  return Buffer.from(found).toString("hex");
}
