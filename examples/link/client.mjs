// Watch and fly a drone over the link, with Node's own modules only.
//
//   node client.mjs [HOST:PORT] watch [FRAMES]
//   node client.mjs [HOST:PORT] fly V_X V_Y V_Z YAW_RATE [SECONDS [TAKE_OFF_HEIGHT]]
//
// Speeds are in m/s and rad/s in the world's axes, z up. If the server needs a token, put it
// into the environment: LINK_TOKEN=... `Link` uses neither sockets nor Node's Buffer, only bytes in
// and bytes out, so a browser can use it with a WebSocket. See docs/protocol.md.

import { createHmac, randomBytes } from "node:crypto";
import net from "node:net";
import { pathToFileURL } from "node:url";

const HEADER = 24;
const CONTROL = 0, DATA = 1, ACKNOWLEDGEMENT = 2;
const HMAC = 1, ACKNOWLEDGE = 2;
const ALL_AXES = 15;
const VELOCITY = "/dh_drone/velocity_data", COMMAND = "/dh_drone/command_velocity";
const TAKE_OFF_TIME = 4; // simulated seconds until the first command to move
const SIZES = { float32: 4, float64: 8, int32: 4, uint32: 4, int64: 8, char: 1 };

const utf8 = new TextEncoder();
const text = new TextDecoder();
const hex = (bytes) => Array.from(bytes, (byte) => byte.toString(16).padStart(2, "0")).join("");
const unhex = (digits) => Uint8Array.from(digits.match(/../g) ?? [], (pair) => parseInt(pair, 16));
const hmac = (key, ...parts) => {
  const made = createHmac("sha256", key);
  for (const part of parts) made.update(part);
  return new Uint8Array(made.digest());
};

/** Bytes in by `feed`, bytes out by `send`; `heard(operation)` and `came(name, t_ns, values)`. */
export class Link {
  constructor(send, { token = "", role = "view", name = "example" } = {}) {
    Object.assign(this, { send, token, role, name });
    this.kept = new Uint8Array(0);
    this.seq = 0;
    this.key = null;
    this.topics = new Map();
    this.ready = () => {};
    this.heard = () => {};
    this.came = () => {};
  }

  feed(data) {
    const all = new Uint8Array(this.kept.length + data.length);
    all.set(this.kept);
    all.set(data, this.kept.length);
    let begin = 0;
    while (all.length - begin >= HEADER) {
      const view = new DataView(all.buffer, begin);
      if (view.getUint16(0) !== 0x4448 || view.getUint8(2) !== 1) {
        throw new Error("this is not a link of version 1");
      }
      const end = begin + HEADER + view.getUint32(12, true);
      if (all.length < end) break;
      const frame = { kind: view.getUint8(3), topic: view.getUint16(4, true) };
      frame.t_ns = view.getBigInt64(16, true);
      this.take(frame, all.subarray(begin + HEADER, end));
      if (view.getUint16(6, true) & ACKNOWLEDGE) {
        this.send(this.frame(ACKNOWLEDGEMENT, 0, new Uint8Array(0), 0n, view.getUint32(8, true)));
      }
      begin = end;
    }
    this.kept = all.slice(begin);
  }

  take({ kind, topic, t_ns }, payload) {
    if (kind === DATA && this.topics.has(topic)) {
      const { name, fields } = this.topics.get(topic);
      this.came(name, t_ns, unpack(fields, payload));
    } else if (kind === CONTROL) {
      const said = JSON.parse(text.decode(payload));
      if (said.op === "hello") this.greet(said);
      if (said.op === "login") this.ready();
      this.heard(said);
    }
  }

  greet(hello) {
    for (const topic of hello.topics) this.topics.set(topic.id, topic);
    this.command = hello.topics.find((topic) => topic.name === COMMAND)?.id;
    if (!hello.login) return this.ready();
    const nonce = randomBytes(16);
    const nonces = [unhex(hello.nonce), nonce];
    const proof = hex(hmac(this.token, "DH1 login", this.role, ...nonces));
    this.say({ op: "login", name: this.name, role: this.role, nonce: hex(nonce), proof });
    this.key = hmac(this.token, "DH1 session", ...nonces);
  }

  /** Send an operation; `commands` if it needs a proof. */
  say(operation, commands = false) {
    this.prove(CONTROL, 0, utf8.encode(JSON.stringify(operation)), 0n, commands);
  }

  /** Command a velocity, acting on the state of `t_ns`. */
  fly(lease, t_ns, velocity) {
    const payload = new DataView(new ArrayBuffer(24));
    payload.setUint32(0, lease, true);
    payload.setUint32(4, ALL_AXES, true);
    velocity.forEach((value, index) => payload.setFloat32(8 + 4 * index, value, true));
    this.prove(DATA, this.command, new Uint8Array(payload.buffer), t_ns, true);
  }

  prove(kind, topic, payload, t_ns, commands) {
    const proven = commands && this.key !== null;
    const bytes = this.frame(kind, topic, payload, t_ns, ++this.seq, proven ? 16 : 0);
    if (proven) {
      const split = bytes.length - 16;
      bytes.set(hmac(this.key, bytes.subarray(0, split)).subarray(0, 16), split);
    }
    this.send(bytes);
  }

  /** A frame's bytes, with room for a proof. */
  frame(kind, topic, payload, t_ns, seq, room = 0) {
    const bytes = new Uint8Array(HEADER + payload.length + room);
    const view = new DataView(bytes.buffer);
    view.setUint16(0, 0x4448);
    view.setUint8(2, 1);
    view.setUint8(3, kind);
    view.setUint16(4, topic, true);
    view.setUint16(6, room ? HMAC : 0, true);
    view.setUint32(8, seq, true);
    view.setUint32(12, payload.length + room, true);
    view.setBigInt64(16, t_ns, true);
    bytes.set(payload, HEADER);
    return bytes;
  }
}

/** A data frame's values by name, by the fields in hello, which are packed without gaps. */
export function unpack(fields, payload) {
  const view = new DataView(payload.buffer, payload.byteOffset, payload.byteLength);
  const read = {
    float32: (at) => view.getFloat32(at, true),
    float64: (at) => view.getFloat64(at, true),
    int32: (at) => view.getInt32(at, true),
    uint32: (at) => view.getUint32(at, true),
    int64: (at) => view.getBigInt64(at, true),
  };
  const values = {};
  let at = 0;
  for (const { name, type, count } of fields) {
    const size = SIZES[type];
    if (type === "char") {
      values[name] = text.decode(payload.subarray(at, at + count)).replace(/\0+$/, "");
    } else {
      const row = Array.from({ length: count }, (_, index) => read[type](at + index * size));
      values[name] = count === 1 ? row[0] : row;
    }
    at += count * size;
  }
  return values;
}

function main(words) {
  let address = "127.0.0.1:7733";
  if (words.length && !["watch", "fly"].includes(words[0])) address = words.shift();
  const [what, ...numbers] = [words[0], ...words.slice(1).map(Number)];
  if (what !== "watch" && (what !== "fly" || numbers.length < 4)) {
    console.error("usage: node client.mjs [HOST:PORT] watch [FRAMES]");
    console.error("       node client.mjs [HOST:PORT] fly V_X V_Y V_Z YAW_RATE [SECONDS [HEIGHT]]");
    process.exit(2);
  }
  const colon = address.lastIndexOf(":");
  const socket = net.connect(Number(address.slice(colon + 1)), address.slice(0, colon));
  socket.setNoDelay(true);
  const role = what === "fly" ? "command" : "view";
  const link = new Link((bytes) => socket.write(bytes), { token: process.env.LINK_TOKEN, role });
  let done = false;
  const end = () => {
    if (!done) link.say({ op: "bye" });
    done = true;
    socket.end();
  };
  socket.on("data", (data) => link.feed(data));
  socket.on("error", (error) => console.error(`the connection failed: ${error.message}`));
  socket.on("close", () => {
    process.exitCode = done ? 0 : 1;
  });

  link.heard = (said) => {
    if (said.op === "hello") return;
    console.log(JSON.stringify(said));
    const refused = said.op === "nack" && ("id" in said || said.code === "not_holder");
    if (said.op === "error" || refused) socket.end();
    if (said.op === "bye") done = true;
  };
  link.ready = () => {
    link.say({ op: "subscribe", topics: [VELOCITY], rate: 20 });
    (what === "watch" ? watch : fly)(link, numbers, end);
  };
}

function watch(link, [frames = Infinity], end) {
  link.came = (name, t_ns, { v_x, v_y, v_z }) => {
    if (name !== VELOCITY || frames-- <= 0) return;
    const shown = [v_x, v_y, v_z].map((value) => value.toFixed(3).padStart(7)).join(" ");
    console.log(`${(Number(t_ns) * 1e-9).toFixed(3).padStart(9)} s  ${shown} m/s`);
    if (frames <= 0) end();
  };
}

/** Take control, answer each state with a command, and return control. */
function fly(link, [v_x, v_y, v_z, yaw_rate, seconds = 2, height = 0], end) {
  const wait = height ? TAKE_OFF_TIME : 0.25;
  let lease = 0;
  let begin = null;
  const before = link.heard;
  link.heard = (said) => {
    before(said);
    if (said.op === "request_control") lease = said.lease;
    if (said.op === "release_control") end();
  };
  link.say({ op: "request_control", id: 1, name: "example" }, true);
  link.came = (name, t_ns) => {
    if (name !== VELOCITY || !lease) return;
    const first = begin === null;
    if (first) begin = t_ns;
    const age = Number(t_ns - begin) * 1e-9;
    if (age >= wait + seconds + 0.5) {
      link.say({ op: "release_control", id: 3, lease }, true);
      lease = 0;
      return;
    }
    const moving = age >= wait && age < wait + seconds; // the first command must be zero
    link.fly(lease, t_ns, moving ? [v_x, v_y, v_z, yaw_rate] : [0, 0, 0, 0]);
    if (first && height) link.say({ op: "flight", id: 2, what: "take_off", height, lease }, true);
  };
}

if (import.meta.url === pathToFileURL(process.argv[1] ?? "").href) main(process.argv.slice(2));
