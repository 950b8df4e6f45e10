/** How many colours tell runs apart before they come round again. */
export const SERIES = 8;

/** CSS variable of the colour of the n-th run in one plot, legend or list; see theme.css. */
export const seriesVariable = (index: number): string => `--series-${(index % SERIES) + 1}`;
