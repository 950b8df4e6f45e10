/** First and last place of a part of a line. */
export type Piece = [from: number, to: number];

/** The parts of some columns in which none of them has a gap. */
export function pieces(...columns: (number | null)[][]): Piece[] {
  const found: Piece[] = [];
  let start = -1;
  const length = columns[0]!.length;
  for (let at = 0; at <= length; at++) {
    const known = at < length && columns.every((column) => Number.isFinite(column[at]));
    if (known && start < 0) start = at;
    if (!known && start >= 0) {
      found.push([start, at - 1]);
      start = -1;
    }
  }
  return found;
}

/** The parts of a piece along which x does not turn back. */
export function strides(x: number[], [first, last]: Piece): Piece[] {
  const found: Piece[] = [];
  let [start, way] = [first, 0];
  for (let at = first + 1; at <= last; at++) {
    const next = Math.sign(x[at]! - x[at - 1]!);
    if (next * way < 0) {
      found.push([start, at - 1]);
      start = at - 1;
    }
    way = next || way;
  }
  return [...found, [start, last]];
}
