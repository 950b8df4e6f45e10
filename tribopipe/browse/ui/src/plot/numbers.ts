/** How numbers are written on axes and in read-outs. */

const COUNT = new Intl.NumberFormat("en-GB");
const MOST_DECIMALS = 12;
const READ_DIGITS = 5;
const READ = new Intl.NumberFormat("en-GB", { maximumSignificantDigits: READ_DIGITS, signDisplay: "negative" });

/** "2,000,000" */
export const counted = (count: number): string => COUNT.format(count);

/** A value as it is read out, to five digits: "23.523", "1.2346×10⁻⁹". */
export function read(value: number): string {
  const size = Math.abs(value);
  if (size === 0 || (size >= 1e-3 && size < 1e7)) return signed(READ.format(value));
  // That of the rounded value: 9.99999 × 10⁻⁴ reads as 1 × 10⁻³.
  const exponent = Number(value.toExponential(READ_DIGITS - 1).split("e")[1]);
  return `${signed(READ.format(value / 10 ** exponent))}×${powerOfTen(exponent)}`;
}

/** The power of ten that is taken out of the numbers on an axis, so that they stay short; 0 for usual sizes. */
export function axisExponent([low, high]: readonly [number, number]): number {
  const size = Math.max(Math.abs(low), Math.abs(high));
  return size === 0 || (size >= 5e-3 && size < 1e7) ? 0 : 3 * Math.floor(Math.log10(size) / 3);
}

/** What an axis is called once a power of ten is taken out: "effective k_D / 10⁻⁹ mm³/(N·mm)". */
export function axisLabel(label: string, exponent: number): string {
  if (exponent === 0) return label;
  const at = label.indexOf(" / ");
  const [name, unit] = at < 0 ? [label, ""] : [label.slice(0, at), ` ${label.slice(at + 3)}`];
  return `${name} / ${powerOfTen(exponent)}${unit}`;
}

/** Numbers at the ticks of an axis, all with the digits that their distance asks for. */
export function ticks(values: number[], step: number, exponent: number): string[] {
  const digits = decimals(step / 10 ** exponent);
  return values.map((value) => fixed(value / 10 ** exponent, digits));
}

function decimals(step: number): number {
  for (let digits = 0; digits < MOST_DECIMALS; digits++) {
    const scaled = step * 10 ** digits;
    if (Math.abs(scaled - Math.round(scaled)) < 1e-6 * Math.max(scaled, 1) && Math.round(scaled) > 0) return digits;
  }
  return MOST_DECIMALS;
}

const fixed = (value: number, digits: number): string => signed(formatOf(digits).format(value));

/** Made once for each number of digits, as making one takes long. */
const formats = new Map<number, Intl.NumberFormat>();

function formatOf(digits: number): Intl.NumberFormat {
  const known = formats.get(digits);
  if (known) return known;
  const fraction = { minimumFractionDigits: digits, maximumFractionDigits: digits };
  const made = new Intl.NumberFormat("en-GB", { ...fraction, signDisplay: "negative" });
  formats.set(digits, made);
  return made;
}

const powerOfTen = (exponent: number): string =>
  `10${[...String(exponent)].map((digit) => "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".indexOf(digit)]).join("")}`;

const signed = (text: string): string => text.replace("-", "−");
