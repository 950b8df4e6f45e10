import type { View } from "./ndarray";

/** Copy the values of one array into another of the same shape; stands in for the package "ndarray-ops" likewise. */
export function assign(to: View, from: View): void {
  copy(to, from, 0, to.offset, from.offset);
}

function copy(to: View, from: View, axis: number, place: number, source: number): void {
  if (axis === to.dimension) {
    to.data[place] = from.data[source];
    return;
  }
  for (let step = 0; step < to.shape[axis]!; step++) {
    copy(to, from, axis + 1, place + step * to.stride[axis]!, source + step * from.stride[axis]!);
  }
}
