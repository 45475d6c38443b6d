/* How many points are drawn while the view moves: as many as the browser draws in a moment. */

/** Of larger clouds at most so many points are drawn while the view moves, */
export const MOVING_MAX = 300000;
/** and however slow the browser draws, at least so many: an outline of what is turned. */
export const MOVING_MIN = 30000;

const [FAST_MS, WANTED_MS, SLOW_MS] = [30, 50, 80]; /* from a frame to the next one: 20 a second follow a hand */

/** How many are to be drawn after a frame of as many took so long. */
export function nextBudget(budget, ms) {
    if (ms > SLOW_MS) return Math.max(MOVING_MIN, Math.floor(budget * Math.max(0.5, WANTED_MS / ms)));
    return ms < FAST_MS ? Math.min(MOVING_MAX, Math.ceil(1.25 * budget)) : budget;
}
