/** Who meets whom: the chassis meets the ground, the rays of the wheels meet their pads, and nothing else meets. */
const groups = (member: number, meets: number): number => (member << 16) | meets;

const CHASSIS = 1;
const GROUND = 2;
const PADS = 4;
const RAYS = 8;

export const CHASSIS_GROUPS = groups(CHASSIS, GROUND);
export const GROUND_GROUPS = groups(GROUND, CHASSIS);
export const PAD_GROUPS = groups(PADS, RAYS);
export const RAY_GROUPS = groups(RAYS, PADS);
