import fc from "fast-check";
import type { NdArray } from "ndarray";
import { describe, expect, it } from "vitest";

// By their paths, as their names stand for the modules that are tested.
// @ts-expect-error Types belong to the name.
import ndarrayPackage from "../../node_modules/ndarray/ndarray.js";
// @ts-expect-error Types belong to the name.
import operationsPackage from "../../node_modules/ndarray-ops/ndarray-ops.js";
import ndarray, { type View } from "./ndarray";
import { assign } from "./ndarrayOps";

type Values = unknown[] | Float64Array | Int32Array | BigInt64Array<ArrayBuffer>;
type Original = NdArray<Values>;

const original = ndarrayPackage as (data: Values, shape?: number[]) => Original;
const originalAssign = (operationsPackage as { assign(to: Original, from: Original): void }).assign;

const KINDS: ((size: number) => Values)[] = [
  (size) => Float64Array.from({ length: size }, (_, place) => place / 4),
  (size) => Int32Array.from({ length: size }, (_, place) => place),
  (size) => BigInt64Array.from({ length: size }, (_, place) => BigInt(place)),
  (size) => Array.from({ length: size }, (_, place) => `value ${place}`),
];

const product = (shape: number[]): number => shape.reduce((one, other) => one * other, 1);

/** Every place of an array of a shape, the last axis going fastest. */
const places = (shape: number[]): number[][] =>
  shape.reduce<number[][]>((all, length) => all.flatMap((place) => upTo(length).map((next) => [...place, next])), [[]]);

const upTo = (length: number): number[] => Array.from({ length }, (_, place) => place);

const shapes = fc.array(fc.integer({ min: 0, max: 4 }), { minLength: 1, maxLength: 4 });

/** A shape, values for it, an order of its axes, and where some of these axes are held. */
const cases = fc.record({ shape: shapes, kind: fc.constantFrom(...KINDS) }).chain(({ shape, kind }) =>
  fc.record({
    shape: fc.constant(shape),
    values: fc.constant(kind(product(shape))),
    order: fc.shuffledSubarray(upTo(shape.length), { minLength: shape.length }),
    held: fc.tuple(...shape.map((length) => (length > 0 ? fc.option(fc.nat(length - 1)) : fc.constant(null)))),
  }),
);

/** Where the values of an array stand, by place. */
const valuesOf = ({ shape, get }: Pick<View, "shape" | "get">, array: object): unknown[] =>
  places(shape).map((place) => get.apply(array as View, place));

const expectAlike = (ours: View, theirs: Original): void => {
  expect([...ours.shape]).toEqual([...theirs.shape]);
  expect([ours.size, ours.dimension, ours.dtype]).toEqual([theirs.size, theirs.dimension, theirs.dtype]);
  expect(valuesOf(ours, ours)).toEqual(valuesOf(theirs as unknown as View, theirs));
};

/** A new row of as many values, as h5web makes one to copy a view into. */
const emptied = (values: Values, size: number): Values =>
  Array.isArray(values) ? [] : new (values.constructor as new (size: number) => Values)(size);

describe("beside the package it stands in for", () => {
  it("transposes and picks alike", () => {
    fc.assert(
      fc.property(cases, ({ shape, values, order, held }) => {
        const [ours, theirs] = [ndarray(values, shape), original(values, shape)];
        expectAlike(ours, theirs);
        expectAlike(ours.transpose(...order), theirs.transpose(...order));
        expectAlike(ours.pick(...held), theirs.pick(...(held as number[])));
        const turned = order.map((axis) => held[axis]!);
        expectAlike(ours.transpose(...order).pick(...turned), theirs.transpose(...order).pick(...turned));
      }),
      { seed: 7 },
    );
  });

  it("copies a view of any kind into a row of its own alike", () => {
    fc.assert(
      fc.property(cases, ({ shape, values, held, order }) => {
        const ours = ndarray(values, shape)
          .transpose(...order)
          .pick(...held.map((_, axis) => held[order[axis]!]!));
        const theirs = original(values, shape)
          .transpose(...order)
          .pick(...(held.map((_, axis) => held[order[axis]!]) as number[]));
        const [one, other] = [emptied(values, ours.size), emptied(values, ours.size)];
        assign(ndarray(one as unknown[], ours.shape), ours);
        originalAssign(original(other, [...theirs.shape]), theirs);
        expect(one).toEqual(other);
      }),
      { seed: 7 },
    );
  });
});

describe("by hand", () => {
  const array = ndarray(upTo(24), [2, 3, 4]);

  it("stands in rows, the last axis going fastest", () => {
    expect(places([2, 3, 4]).map((place) => array.get(...place))).toEqual(upTo(24));
    expect(ndarray([5, 6]).shape).toEqual([2]);
  });

  it("finds a[i][j][k] at [k][i][j] of what is transposed so", () => {
    const turned = array.transpose(2, 0, 1);
    expect(turned.shape).toEqual([4, 2, 3]);
    for (const [i, j, k] of places([2, 3, 4]) as [number, number, number][]) {
      expect(turned.get(k, i, j)).toBe(12 * i + 4 * j + k);
    }
  });

  it("picks a row, a column and a single value", () => {
    expect(upTo(4).map((k) => array.pick(1, 2, null).get(k))).toEqual([20, 21, 22, 23]);
    expect(upTo(2).map((i) => array.pick(null, 1, 3).get(i))).toEqual([7, 19]);
    expect(array.pick(1, 0, 2).dimension).toBe(0);
    expect(array.pick(1, 0, 2).get(0)).toBe(14);
  });

  it("has no value where an axis is empty", () => {
    expect(ndarray([], [0, 3]).size).toBe(0);
    const to = [1, 2];
    assign(ndarray(to, [0, 3]), ndarray([], [0, 3]));
    expect(to).toEqual([1, 2]);
  });

  it("holds a scalar in no dimension", () => {
    expect(ndarray([3], []).get()).toBe(3);
  });
});
