import type { Line, Mark, Panel } from "../api";
import { lineStrokes, markStrokes, type Colouring, type Stroke } from "./strokes";

/** A line or a mark with how it is drawn, and a name of its own that stays when the plot is asked for anew. */
export interface Styled<T extends Line | Mark> {
  key: string;
  thing: T;
  stroke: Stroke;
  /** As the canvas takes it. */
  colour: string;
}

/** Everything of a panel as it is drawn. */
export interface StyledPanel {
  lines: Styled<Line>[];
  marks: Styled<Mark>[];
}

/** Say how everything of a panel is drawn, with the colours that the theme's variables stand for. */
export function styledPanel(panel: Panel, colouring: Colouring, colour: (variable: string) => string): StyledPanel {
  const styled = <T extends Line | Mark>(kind: string, things: T[], strokes: Stroke[]): Styled<T>[] =>
    things.map((thing, place) => {
      const stroke = strokes[place]!;
      const alike = things.slice(0, place).filter(({ run, name }) => run === thing.run && name === thing.name);
      const key = JSON.stringify([panel.label, kind, thing.run, thing.name, alike.length]);
      return { key, thing, stroke, colour: colour(stroke.colour) };
    });
  return {
    lines: styled("line", panel.lines, lineStrokes(panel, colouring)),
    marks: styled("mark", panel.marks, markStrokes(panel, colouring)),
  };
}
