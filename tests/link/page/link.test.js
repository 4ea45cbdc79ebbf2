import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import test, { mock } from "node:test";

import { Link, Phase } from "../../../workbench/link/page/link.js";
import { connection, holder } from "../../../workbench/link/page/screen.js";
import { Decoder, Topic, frameBytes } from "../../../workbench/link/page/wire.js";

const topics = JSON.parse(readFileSync(process.env.TOPICS, "utf8"));
const COMMAND = new Topic(topics.find((each) => each.id === 8));
const NONCE = "000102030405060708090a0b0c0d0e0f";
const LIMITS = { level_speed: 8, climb_rate: 8, yaw_rate: 0.4 };
const TOKEN = "0123456789abcdef";

/** The server's end of a WebSocket. */
class Socket {
  readyState = 1;
  bufferedAmount = 0;
  sent = [];
  seq = 0;
  decoder = new Decoder();
  closedByPage = false;
  alive = false; // whether pings are answered
  send(bytes) {
    for (const frame of this.decoder.feed(bytes)) {
      this.sent.push(frame);
      const said = frame.kind === 0 ? JSON.parse(Buffer.from(frame.payload)) : {};
      if (this.alive && said.op === "ping") this.say({ op: "pong", id: said.id, t_ns: 0 });
    }
  }
  close() {
    this.closedByPage = true;
    this.readyState = 3;
  }
  end() {
    this.readyState = 3;
    this.onclose?.();
  }
  say(operation) {
    this.put({ kind: 0, payload: new TextEncoder().encode(JSON.stringify(operation)) });
  }
  put(frame) {
    const bytes = frameBytes({ seq: ++this.seq, ...frame });
    this.onmessage?.({ data: bytes.buffer });
  }
  place(tNs, flags = 0) {
    this.put({ kind: 1, topic: 2, tNs, flags, payload: new Uint8Array(36) });
  }
  hello(more = {}) {
    this.say({ op: "hello", peer: 3, vehicle: "v", nonce: NONCE, login: false, limits: LIMITS, topics, ...more });
  }
  /** What the page has said since, as operations. */
  heard() {
    const frames = this.sent.splice(0);
    return frames.filter((each) => each.kind === 0).map((each) => JSON.parse(Buffer.from(each.payload)));
  }
  commands() {
    return this.sent.filter((each) => each.kind === 1).map((each) => COMMAND.unpack(each.payload));
  }
}

class Listener {
  words = [];
  tokens = [];
  grants = 0;
  asked = { v: [1, 2, 3], yawRate: 0.25 };
  changed() {}
  sample() {}
  granted() {
    this.grants++;
  }
  said(text) {
    this.words.push(text);
  }
  token(said) {
    this.tokens.push(said);
  }
  wanted() {
    return this.asked;
  }
}

/** Run with a clock that only goes when it is told to. */
function timed(name, run) {
  test(name, () => {
    mock.timers.enable({ apis: ["setTimeout", "setInterval"] });
    const clock = { now: 1000 };
    const go = (ms) => {
      for (let i = 0; i < ms; i += 10) {
        clock.now += 10;
        mock.timers.tick(10);
      }
    };
    const sockets = [];
    const listener = new Listener();
    const open = () => sockets[sockets.push(new Socket()) - 1];
    const link = new Link({ open, listener, name: "phone", now: () => clock.now });
    try {
      const stand = (ms) => (clock.now += ms);
      run({ link, listener, sockets, go, stand, socket: () => sockets.at(-1) });
    } finally {
      link.drop();
      clearTimeout(link.waiting);
      mock.timers.reset();
    }
  });
}

/** Connect and take control, as a pilot does. */
function flying({ link, socket }) {
  link.start();
  socket().alive = true;
  socket().hello();
  socket().place(5_000_000_000n);
  link.takeControl();
  socket().say({ op: "request_control", id: 99, lease: 77, expires: 0.5 });
}

timed("hello is answered with a name and a subscription to what there is", ({ link, socket }) => {
  link.start();
  socket().hello();
  const [login, subscribe] = socket().heard();
  assert.deepEqual([login.op, login.name], ["login", "phone"]);
  assert.equal(subscribe.op, "subscribe");
  assert.ok(subscribe.topics.includes("/dh_drone/position_data") && subscribe.rate <= 20);
  assert.equal(link.phase, Phase.OPEN);
});

timed("a batch is acknowledged by its last frame's number", ({ link, socket }) => {
  link.start();
  socket().hello();
  socket().sent.length = 0;
  socket().place(1n);
  socket().place(2n, 2);
  assert.deepEqual(socket().sent.map((each) => [each.kind, each.seq]), [[2, 3]]);
});

timed("commands carry the newest time that a state or a pong tells, also of a flight begun anew", (on) => {
  flying(on);
  const told = () => on.socket().sent.findLast((each) => each.kind === 1).tNs;
  on.socket().say({ op: "pong", id: 0, t_ns: 5_600_000_000 });
  on.go(100);
  assert.equal(told(), 5_600_000_000n);
  on.socket().place(5_300_000_000n); // was on its way for longer
  on.go(100);
  assert.equal(told(), 5_600_000_000n);
  on.socket().place(5_700_000_000n);
  on.go(100);
  assert.equal(told(), 5_700_000_000n);
  on.socket().place(100_000_000n);
  on.go(100);
  assert.equal(told(), 100_000_000n);
});

timed("the first command after a grant is neutral, then come the sticks 20 times a second", (on) => {
  flying(on);
  assert.equal(on.listener.grants, 1);
  on.go(1000);
  const [first, ...rest] = on.socket().commands();
  assert.deepEqual(first, { lease: 77, axes: 15, v_x: 0, v_y: 0, v_z: 0, yaw_rate: 0 });
  assert.deepEqual(rest[0], { lease: 77, axes: 15, v_x: 1, v_y: 2, v_z: 3, yaw_rate: 0.25 });
  assert.equal(rest.length, 20);
  assert.ok(on.socket().sent.filter((each) => each.kind === 1).every((each) => each.tNs === 5_000_000_000n));
});

timed("nothing is commanded before control is granted, nor where nobody looks at the page", (on) => {
  on.link.start();
  on.socket().hello();
  on.go(1000);
  assert.deepEqual(on.socket().commands(), []);
  flying(on);
  on.listener.asked = null;
  on.socket().sent.length = 0;
  on.go(1000);
  assert.deepEqual(on.socket().commands(), []);
});

timed("commands that would lie in a queue are not sent", (on) => {
  flying(on);
  on.socket().sent.length = 0;
  on.socket().bufferedAmount = 5000;
  on.go(500);
  assert.deepEqual(on.socket().commands(), []);
});

for (const state of [
  { hand: "operator", peer: 0, stage: "live" },
  { hand: "client", peer: 4, stage: "live" },
  { hand: "client", peer: 3, stage: "hold" },
  { hand: "nobody", peer: 0, stage: "lost" },
]) {
  timed(`control ends where ${state.hand} ${state.peer} flies, stage ${state.stage}`, (on) => {
    flying(on);
    on.socket().say({ op: "control_state", name: "x", age: 0, reason: "because", ...state });
    assert.equal(on.link.flying, false);
    assert.match(on.listener.words.at(-1), /because/);
    on.socket().sent.length = 0;
    on.go(1000);
    assert.deepEqual(on.socket().commands(), []);
  });
}

timed("control that is told to be mine goes on", (on) => {
  flying(on);
  on.socket().say({ op: "control_state", hand: "client", peer: 3, stage: "live", name: "phone", age: 0, reason: "" });
  assert.equal(on.link.flying, true);
});

timed("a refused command ends control only if it is of this lease", (on) => {
  flying(on);
  on.socket().say({ op: "nack", seq: 1, code: "not_holder", said: "late" });
  assert.equal(on.link.flying, true);
  on.socket().say({ op: "nack", seq: 1000, code: "scaled", said: "over a limit" });
  assert.equal(on.link.flying, true);
  on.socket().say({ op: "nack", seq: 1000, code: "not_holder", said: "another flies" });
  assert.equal(on.link.flying, false);
  assert.deepEqual(on.listener.words, ["late", "over a limit", "another flies"]);
});

timed("release says neutral, gives the lease back and commands no more", (on) => {
  flying(on);
  on.go(100);
  on.socket().sent.length = 0;
  on.link.releaseControl();
  assert.equal(on.socket().commands()[0].v_x, 0);
  on.go(500);
  assert.equal(on.socket().commands().length, 1);
  assert.deepEqual(on.socket().heard().map((each) => [each.op, each.lease])[0], ["release_control", 77]);
});

timed("a refusal names what was asked for", (on) => {
  on.link.start();
  on.socket().hello();
  on.link.takeControl();
  const { id } = on.socket().heard().at(-1);
  on.socket().say({ op: "nack", id, code: "held", said: "tablet flies" });
  assert.deepEqual(on.listener.words, ["Could not take control: tablet flies"]);
  on.link.fly("take_off");
  assert.equal(on.listener.words.at(-1), "Could not take off: take control first");
});

timed("flight operations carry the lease", (on) => {
  flying(on);
  on.link.fly("take_off");
  const { op, what, lease } = on.socket().heard().at(-1);
  assert.deepEqual([op, what, lease], ["flight", "take_off", 77]);
});

timed("a lost connection comes back after growing pauses, without control", (on) => {
  flying(on);
  on.socket().end();
  assert.equal(on.link.phase, Phase.WAITING);
  assert.match(on.listener.words.at(-1), /holds/);
  for (const pause of [500, 1000, 2000, 4000, 8000, 8000]) {
    const before = on.sockets.length;
    on.go(pause - 10);
    assert.equal(on.sockets.length, before);
    on.go(10);
    assert.equal(on.sockets.length, before + 1);
    on.socket().end();
  }
  on.go(8000);
  on.socket().hello();
  on.socket().place(1n);
  on.go(2000);
  assert.equal(on.link.phase, Phase.OPEN);
  assert.equal(on.link.flying, false);
  assert.deepEqual(on.socket().commands(), []);
  assert.ok(!on.socket().heard().some((each) => each.op === "request_control"));
  // Where it worked, the next pause is short again.
  const before = on.sockets.length;
  on.socket().end();
  on.go(500);
  assert.equal(on.sockets.length, before + 1);
});

timed("an attempt that nobody answers, and a server that falls silent, are given up", (on) => {
  on.link.start();
  on.go(7700);
  assert.ok(on.sockets[0].closedByPage && on.sockets.length > 1);
  on.socket().hello();
  on.go(7700);
  assert.ok(on.sockets[1].closedByPage);
  assert.match(on.listener.words.at(-1), /Nothing was heard/);
});

timed("pings that are answered keep the connection and tell its age", (on) => {
  on.link.start();
  on.socket().hello();
  for (let i = 0; i < 20; i++) {
    on.go(980);
    const ping = on.socket().heard().findLast((each) => each.op === "ping");
    on.go(20);
    if (ping) on.socket().say({ op: "pong", id: ping.id, t_ns: 0 });
  }
  assert.equal(on.sockets.length, 1);
  assert.ok(on.link.age < 1000);
});

timed("who was put out by the operator waits longest", (on) => {
  on.link.start();
  on.socket().hello();
  on.socket().say({ op: "error", code: "disconnected", said: "the operator ended it" });
  on.socket().end();
  assert.deepEqual(on.listener.words, ["the operator ended it"]);
  on.go(7900);
  assert.equal(on.sockets.length, 1);
});

timed("a server with tokens is left until somebody types one", (on) => {
  on.link.start();
  on.socket().hello({ login: true });
  assert.equal(on.link.phase, Phase.TOKEN);
  assert.ok(on.socket().closedByPage);
  assert.deepEqual(on.listener.tokens, [""]);
  on.go(60_000);
  assert.equal(on.sockets.length, 1);
});

timed("login has the token of the role, and nothing else has it", (on) => {
  on.link.logIn({ token: TOKEN, role: "command" });
  on.socket().hello({ login: true });
  const [login] = on.socket().heard();
  assert.deepEqual(login, { op: "login", id: login.id, name: "phone", role: "command", token: TOKEN });
  on.socket().say({ op: "login", id: login.id, role: "command" });
  assert.equal(on.link.phase, Phase.OPEN);
  on.socket().place(1n);
  on.link.takeControl();
  on.socket().say({ op: "request_control", id: 99, lease: 77, expires: 0.5 });
  on.link.fly("arm");
  on.go(200);
  const { sent } = on.socket();
  assert.ok(sent.every(({ seq }, i) => i === 0 || seq > sent[i - 1].seq));
  assert.ok(on.socket().commands().length >= 4);
  assert.equal(JSON.stringify(on.socket().heard()).includes(TOKEN), false);
});

timed("a link that dies is noticed within its lease, and nobody flies through it any more", (on) => {
  flying(on);
  for (let i = 0; i < 40; i++) {
    on.go(50);
    on.socket().place(6_000_000_000n);
  }
  assert.equal(on.link.flying, true);
  assert.deepEqual(connection(on.link), ["open", "Connected"]);
  on.socket().alive = false; // nothing comes any more
  on.go(600);
  assert.deepEqual(connection(on.link), ["lost", "No connection"]);
  on.socket().sent.length = 0;
  assert.equal(holder(on.link)[0], "You do not fly");
  assert.equal(on.link.flying, false);
  assert.match(on.listener.words.at(-1), /the server is silent/);
  on.link.takeControl();
  on.link.fly("land");
  on.go(300);
  assert.ok(on.socket().sent.every((each) => each.kind === 0), "no stick counts");
  assert.ok(on.socket().heard().every((each) => each.op === "ping"));
  on.socket().place(7_000_000_000n); // it was only slow
  assert.deepEqual(connection(on.link), ["open", "Connected"]);
  assert.equal(on.link.flying, false, "and control must be taken again");
  on.go(300);
  assert.deepEqual(on.socket().commands(), []);
});

timed("a page that stood still itself looks again before it gives the link up", (on) => {
  flying(on);
  on.stand(3000);
  on.go(10);
  on.socket().place(8_000_000_000n); // had come meanwhile
  on.go(300);
  assert.equal(on.link.silent, false);
});

timed("a wrong token is asked for anew and not tried again", (on) => {
  on.link.logIn({ token: TOKEN, role: "view" });
  on.socket().hello({ login: true });
  on.socket().say({ op: "error", code: "bad_login", said: "the token is not that of role view" });
  on.socket().end();
  assert.deepEqual(on.listener.tokens, ["the token is not that of role view"]);
  on.go(20_000);
  assert.equal(on.sockets.length, 1);
});

timed("what is no frame ends the connection and says so", (on) => {
  on.link.start();
  on.socket().onmessage({ data: new TextEncoder().encode("HTTP/1.1 400 Bad Request").buffer });
  assert.equal(on.link.phase, Phase.WAITING);
  assert.match(on.listener.words[0], /cannot be understood/);
});

timed("a frame of a kind that may be skipped is skipped", (on) => {
  on.link.start();
  on.socket().hello();
  on.socket().put({ kind: 0x81, payload: new Uint8Array(3) });
  assert.equal(on.link.phase, Phase.OPEN);
});
