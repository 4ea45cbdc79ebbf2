// Proofs that this page knows the token; the token itself is never sent. See docs/protocol.md.

import { fromHex, hmac, joined, toHex } from "./sha256.js";
import { PROOF } from "./wire.js";

const text = new TextEncoder();

/** Return 32 hex digits that nobody guesses. */
export function newNonce() {
  return toHex(crypto.getRandomValues(new Uint8Array(16)));
}

/** Return the proof of a login as 64 hex digits. */
export function loginProof(token, role, serverNonce, clientNonce) {
  const said = joined(text.encode(`DH1 login${role}`), fromHex(serverNonce), fromHex(clientNonce));
  return toHex(hmac(text.encode(token), said));
}

/** Return the key with which the frames of a session are signed. */
export function sessionKey(token, serverNonce, clientNonce) {
  const said = joined(text.encode("DH1 session"), fromHex(serverNonce), fromHex(clientNonce));
  return hmac(text.encode(token), said);
}

/** Return the 16 bytes that follow a frame that commands. */
export function frameProof(key, signedPart) {
  return hmac(key, signedPart).slice(0, PROOF);
}
