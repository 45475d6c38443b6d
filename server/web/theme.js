/* Light and dark: the system's choice until the button was pressed, which this browser remembers. */

import { forGood } from './keep.js';

const KEPT = 'voronoid-theme';
const system = matchMedia('(prefers-color-scheme: dark)');

/** The value of one of the style sheet's colours. */
export const color = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

/** Wires the button; changed() is called now and after each change. */
export function wireTheme(button, changed) {
    const apply = () => {
        const dark = (forGood.get(KEPT) || (system.matches ? 'dark' : 'light')) === 'dark';
        document.documentElement.dataset.theme = dark ? 'dark' : 'light';
        button.textContent = dark ? 'Light' : 'Dark';
        button.setAttribute('aria-label', dark ? 'Change to light colours' : 'Change to dark colours');
        changed();
    };
    button.addEventListener('click', () => {
        forGood.set(KEPT, document.documentElement.dataset.theme === 'dark' ? 'light' : 'dark');
        apply();
    });
    system.addEventListener('change', apply);
    apply();
}
