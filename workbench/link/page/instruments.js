// Attitude with heading, and the ring of obstacles, drawn as SVG; colours are the style sheet's.

import { SECTORS } from "./scan.js";

const SVG = "http://www.w3.org/2000/svg";
const PITCH_SCALE = 1.6; // units of the drawing a degree

/** Return the compass heading in whole degrees; yaw is about z, 0 to the east, north is y [rad]. */
export function heading(yaw) {
  return (((90 - degrees(yaw)) % 360) + 360.5) % 360 | 0;
}

/** Return how the horizon lies as an SVG transform; positive pitch looks down. */
export function horizon(roll, pitch) {
  const shift = Math.max(-80, Math.min(80, -degrees(pitch) * PITCH_SCALE));
  return `rotate(${(-degrees(roll)).toFixed(2)}) translate(0 ${shift.toFixed(2)})`;
}

/** Return in words where the nearest obstacle is, and how far [m]. */
export function nearestWords(nearest) {
  const least = Math.min(...nearest);
  if (!Number.isFinite(least)) return "Nothing near";
  const eighth = Math.round((nearest.indexOf(least) / SECTORS) * 8) % 8;
  const where = ["ahead", "ahead left", "left", "behind left", "behind"];
  where.push("behind right", "right", "ahead right");
  return `${least.toFixed(least < 9.95 ? 1 : 0)} m ${where[eighth]}`;
}

/** Attitude: sky and ground as they lie, a fixed drone, and a compass around. */
export class Attitude {
  constructor(svg) {
    this.svg = svg;
    svg.setAttribute("viewBox", "-100 -100 200 200");
    const clip = add(add(svg, "defs"), "clipPath", { id: "inside" });
    add(clip, "circle", { r: 72 });
    const window = add(svg, "g", { "clip-path": "url(#inside)" });
    this.horizon = add(window, "g");
    add(this.horizon, "rect", { class: "sky", x: -200, y: -300, width: 400, height: 300 });
    add(this.horizon, "rect", { class: "ground", x: -200, y: 0, width: 400, height: 300 });
    add(this.horizon, "line", { class: "horizon", x1: -200, x2: 200, y1: 0, y2: 0 });
    for (const degree of [-30, -20, -10, 10, 20, 30]) {
      const [y, half] = [-degree * PITCH_SCALE, degree % 20 ? 12 : 20];
      add(this.horizon, "line", { class: "ladder", x1: -half, x2: half, y1: y, y2: y });
    }
    add(svg, "path", { class: "craft", d: "M-44 0h26l8 8 M44 0h-26l-8 8" });
    add(svg, "circle", { class: "craft dot", r: 2.5 });
    this.compass = add(svg, "g");
    for (let degree = 0; degree < 360; degree += 30) {
      const turn = { transform: `rotate(${degree})` };
      if (degree % 90) add(this.compass, "line", { class: "tick", y1: -92, y2: -82, ...turn });
      else add(this.compass, "text", { class: "compass", y: -80, ...turn }).textContent = "NESW"[degree / 90];
    }
    add(svg, "path", { class: "lubber", d: "M0 -77 l-6 11 h12 z" });
  }

  show(roll, pitch, yaw) {
    const to = heading(yaw);
    this.horizon.setAttribute("transform", horizon(roll, pitch));
    this.compass.setAttribute("transform", `rotate(${-to})`);
    const words = `roll ${degrees(roll).toFixed(0)}°, pitch ${degrees(pitch).toFixed(0)}°`;
    this.svg.setAttribute("aria-label", `Attitude: ${words}`);
  }
}

/** The nearest obstacles around, ahead is up; the rim is `reach` away [m]. */
export class Ring {
  constructor(svg, reach = 10) {
    Object.assign(this, { svg, reach });
    svg.setAttribute("viewBox", "-100 -100 200 200");
    add(svg, "circle", { class: "dial", r: 92 });
    for (const metres of [2, 5]) {
      add(svg, "circle", { class: "circle", r: this.radius(metres) });
    }
    add(svg, "path", { class: "craft-above", d: "M0 -12 L8 9 L0 4 L-8 9 Z" });
    this.sectors = add(svg, "path", { class: "obstacles" });
    this.nearest = add(svg, "path", { class: "nearest" });
    for (const metres of [2, 5, reach]) {
      const along = this.radius(metres) * Math.SQRT1_2;
      add(svg, "text", { class: "scale", x: -along, y: along + 5 }).textContent = metres;
    }
  }

  radius(metres) {
    return 92 * Math.sqrt(Math.min(metres, this.reach) / this.reach);
  }

  show(nearest) {
    const least = Math.min(...nearest);
    const arcs = nearest.map((metres, i) => (metres < this.reach ? this.arc(metres, i) : ""));
    this.sectors.setAttribute("d", arcs.join(""));
    this.nearest.setAttribute("d", least < this.reach ? arcs[nearest.indexOf(least)] : "");
    this.svg.setAttribute("aria-label", `Obstacles: ${nearestWords(nearest)}`);
  }

  arc(metres, sector) {
    const radius = Math.max(this.radius(metres), 14);
    const [from, to] = [sector - 0.46, sector + 0.46].map((each) => (each * 2 * Math.PI) / SECTORS);
    const point = (angle) => `${(-radius * Math.sin(angle)).toFixed(1)} ${(-radius * Math.cos(angle)).toFixed(1)}`;
    return `M${point(from)}A${radius.toFixed(1)} ${radius.toFixed(1)} 0 0 0 ${point(to)}`;
  }
}

function degrees(radians) {
  return (radians * 180) / Math.PI;
}

function add(parent, name, attributes = {}) {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  return parent.appendChild(made);
}
