/** Colours of the curves of a plot and of the layers of the map. */

/** The colour of a curve by its number; all have the same lightness, with a contrast above 3 on light and on dark paper (WCAG 2.2, 1.4.11). */
export const colour = (number: number): string => `oklch(60% 0.17 ${(255 + number * 137.5) % 360})`;
