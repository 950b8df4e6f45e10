/** One axis: where values are, from 0 to 1, and which of them have a tick. */
export interface Scale {
  log: boolean;
  from: number;
  to: number;
  ticks: number[];
  /** Distance of ticks, which sets their digits; of a logarithmic axis, that of its lowest. */
  step: number;
}

const MARGIN = 0.05;
const TICKS = 10;
/** A logarithmic axis over fewer decades has ticks at 1, 2 and 5 of each. */
const FEW_DECADES = 3;

/** A logarithmic axis with fewer ticks has those of a linear one. */
const FEW_TICKS = 3;

/** Ratio of the largest to the smallest value from which an axis is logarithmic unless another is chosen. */
const WIDE = 30;

/** Whether an axis is logarithmic: as chosen, "1" or "0"; without a choice where positive values span decades. */
export function isLogarithmic(chosen: string | null, values: number[]): boolean {
  if (chosen !== null) return chosen === "1";
  return values.length > 0 && Math.min(...values) > 0 && Math.max(...values) >= WIDE * Math.min(...values);
}

/** The axis for some values, of which a logarithmic one must have positive ones only. */
export function scaleOf(values: number[], log: boolean): Scale {
  const [low, high] = values.length ? [Math.min(...values), Math.max(...values)] : [1, 10];
  return log ? logarithmic(low, high) : linear(low, high);
}

function linear(low: number, high: number): Scale {
  const margin = high > low ? MARGIN * (high - low) : Math.abs(low) * MARGIN || 1;
  const [from, to] = [low - margin, high + margin];
  return { log: false, from, to, ...even(from, to) };
}

/** Ticks at equal distances. */
function even(from: number, to: number): { ticks: number[]; step: number } {
  const step = niceStep((to - from) / TICKS);
  const ticks = [];
  for (let count = Math.ceil(from / step); count * step <= to; count++) ticks.push(Number((count * step).toPrecision(12)));
  return { ticks, step };
}

/** The lowest of 1, 2, 5, 10, 20, … that is not below a distance. */
function niceStep(least: number): number {
  const power = 10 ** Math.floor(Math.log10(least));
  const factor = [1, 2, 5, 10].find((one) => one * power >= least * (1 - 1e-9)) ?? 10;
  return Number((factor * power).toPrecision(1));
}

function logarithmic(low: number, high: number): Scale {
  const margin = high > low ? (high / low) ** MARGIN : 2;
  const [from, to] = [low / margin, high * margin];
  const decades = Math.log10(to / from);
  const every = Math.ceil(decades / TICKS);
  const ticks = [];
  for (let power = Math.floor(Math.log10(from)); power <= Math.ceil(Math.log10(to)); power += every) {
    for (const factor of decades < FEW_DECADES ? [1, 2, 5] : [1]) ticks.push(Number(`${factor}e${power}`));
  }
  const within = ticks.filter((tick) => tick >= from && tick <= to);
  if (within.length < FEW_TICKS) return { log: true, from, to, ...even(from, to) };
  return { log: true, from, to, ticks: within, step: within[0] ?? from };
}

/** Where a value is, from 0 at the start of the axis to 1 at its end. */
export function placeOn({ log, from, to }: Scale, value: number): number {
  return log ? Math.log(value / from) / Math.log(to / from) : (value - from) / (to - from);
}
