/**
 * Arrays of several dimensions over one row of values, as h5web uses them.
 *
 * Stands in for the package of that name, which makes its code from texts as it runs: the page's content-security
 * policy forbids that, and is worth more.
 */

type Values = { [place: number]: unknown; readonly length: number };

/** A view of values: each axis has a length and a stride. */
export class View {
  readonly size: number;
  readonly dimension: number;

  constructor(
    readonly data: Values,
    readonly shape: number[],
    readonly stride: number[],
    readonly offset: number,
  ) {
    this.size = shape.reduce((product, length) => product * length, 1);
    this.dimension = shape.length;
  }

  /** "float64", "uint8_clamped", …; "array" for what is no typed array. */
  get dtype(): string {
    const name = Object.prototype.toString.call(this.data).slice("[object ".length, -"Array]".length);
    return name === "Uint8Clamped" ? "uint8_clamped" : name.toLowerCase() || "array";
  }

  get(...place: number[]): unknown {
    return this.data[this.index(place)];
  }

  /** What is left when some axes are held at a place; null keeps an axis. */
  pick(...held: (number | null)[]): View {
    const kept = this.shape.map((_, axis) => axis).filter((axis) => typeof held[axis] !== "number");
    return this.ordered(kept, this.index(this.shape.map((_, axis) => held[axis] ?? 0)));
  }

  /** The same values with the axes in another order. */
  transpose(...axes: number[]): View {
    return this.ordered(axes, this.offset);
  }

  /** Where a value stands among all; places beyond the last axis count for nothing. */
  private index(place: number[]): number {
    return this.stride.reduce((sum, stride, axis) => sum + stride * place[axis]!, this.offset);
  }

  private ordered(axes: number[], offset: number): View {
    const of = (lengths: number[]) => axes.map((axis) => lengths[axis]!);
    return new View(this.data, of(this.shape), of(this.stride), offset);
  }
}

/** Values in rows, the last axis going fastest. */
export default function ndarray(data: Values, shape: number[] = [data.length]): View {
  const stride = shape.map((_, axis) => shape.slice(axis + 1).reduce((product, length) => product * length, 1));
  return new View(data, shape, stride, 0);
}
