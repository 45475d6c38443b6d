/* What the browser remembers: for good, or as long as the tab's session. One that may remember nothing (its cookies are shut off) forgets
 * with the page. */

/** @param {'localStorage' | 'sessionStorage'} area */
const makeKeep = (area) => {
    const own = new Map();
    return {
        get(name) {
            try {
                return window[area].getItem(name) || '';
            } catch {
                return own.get(name) || '';
            }
        },
        /* '' forgets. */
        set(name, value) {
            try {
                if (value) window[area].setItem(name, value);
                else window[area].removeItem(name);
            } catch {
                own.set(name, value);
            }
        },
    };
};

export const forGood = makeKeep('localStorage');
export const forSession = makeKeep('sessionStorage');
