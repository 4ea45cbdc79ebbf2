// A lidar's cloud as a ring: the nearest obstacle in each direction at the drone's height.

export const SECTORS = 36;
const BAND = 1.0; // half height of the slice in which obstacles count [m]
const GROUND = 0.3; // what is lower above W's origin is taken for the ground [m]

/** The rays of a lidar, from the `about` of its topic. */
export class Scan {
  /** about: azimuths and elevations, each as first angle, step and count [rad], and R_BS. */
  constructor(about) {
    const { azimuths, elevations, R_BS } = about;
    this.about = about;
    const rays = elevations[2] * azimuths[2];
    this.directions = new Float64Array(3 * rays);
    let at = 0;
    for (const elevation of angles(elevations)) {
      for (const azimuth of angles(azimuths)) {
        const level = Math.cos(elevation);
        const ray = [level * Math.cos(azimuth), level * Math.sin(azimuth), Math.sin(elevation)];
        for (const row of R_BS) {
          this.directions[at++] = row[0] * ray[0] + row[1] * ray[1] + row[2] * ray[2];
        }
      }
    }
  }

  /** Return the nearest level distance in each sector, ahead first and then to the left [m];
   * Infinity where nothing is.
   *
   * Args:
   *   ranges: layer by layer [m]; -Infinity is too near to measure.
   *   roll, pitch: of the drone, which level the rays [rad].
   *   height: of the drone in W [m].
   */
  nearest(ranges, roll, pitch, height) {
    const found = new Array(SECTORS).fill(Infinity);
    const [cr, sr, cp, sp] = [Math.cos(roll), Math.sin(roll), Math.cos(pitch), Math.sin(pitch)];
    for (let i = 0; i < ranges.length; i++) {
      const range = Math.max(ranges[i], 0);
      if (!Number.isFinite(range)) continue;
      const x = this.directions[3 * i];
      const y = this.directions[3 * i + 1];
      const z = this.directions[3 * i + 2];
      const turned = sr * y + cr * z;
      const above = range * (cp * turned - sp * x);
      if (Math.abs(above) > BAND || height + above < GROUND) continue;
      const ahead = cp * x + sp * turned;
      const left = cr * y - sr * z;
      const turn = Math.round((Math.atan2(left, ahead) / (2 * Math.PI)) * SECTORS);
      const sector = (turn + SECTORS) % SECTORS;
      found[sector] = Math.min(found[sector], range * Math.hypot(ahead, left));
    }
    return found;
  }
}

function angles([first, step, count]) {
  return Array.from({ length: count }, (_, i) => first + i * step);
}
