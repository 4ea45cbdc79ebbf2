// The lease under which this page commands: first nothing, then what the sticks ask for.

import { Kind } from "./wire.js";

export const NEUTRAL = Object.freeze({ v: [0, 0, 0], yawRate: 0 });

const PERIOD = 50; // between commands [ms]
const ALL_AXES = 15;
const BACKLOG = 2048; // bytes that wait to be sent, beyond which commands would arrive too late

export class Lease {
  constructor(link) {
    this.link = link;
    this.number = 0; // 0 while another flies, or nobody
    this.before = 0; // number of the last frame before it was granted
    this.begun = false; // whether its first, neutral command was sent
  }

  /** Command from now on, until `end`. */
  begin(number) {
    this.end();
    this.number = number;
    this.before = this.link.seq;
    this.begun = false;
    this.link.listener.granted();
    this.timer = setInterval(() => this.steer(), PERIOD);
    this.steer();
    this.link.listener.changed();
  }

  end() {
    this.number = 0;
    clearInterval(this.timer);
  }

  /** Command what the sticks ask for; first nothing. */
  steer() {
    const wanted = this.begun ? this.link.listener.wanted() : NEUTRAL;
    this.begun = true;
    if (wanted !== null) this.command(wanted);
  }

  command({ v, yawRate }) {
    const topic = this.link.topic("command_velocity");
    if (!topic || this.link.socket.bufferedAmount > BACKLOG) return;
    const [v_x, v_y, v_z] = v;
    const values = { lease: this.number, axes: ALL_AXES, v_x, v_y, v_z, yaw_rate: yawRate };
    const payload = topic.pack(values);
    this.link.send({ kind: Kind.DATA, topic: topic.id, tNs: this.link.newest, payload });
  }
}
