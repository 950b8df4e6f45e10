import type { Step } from "./view";

const STEPS: { step: Step; sign: string; label: string }[] = [
  { step: "out", sign: "−", label: "Zoom out" },
  { step: "in", sign: "+", label: "Zoom in" },
  { step: "left", sign: "‹", label: "Move left" },
  { step: "right", sign: "›", label: "Move right" },
];

/** Zoom for those who do not drag. */
export function ZoomTools({ title, onStep }: { title: string; onStep(step: Step): void }) {
  return (
    <div className="plot-tools" role="group" aria-label={`Zoom of ${title}`}>
      {STEPS.map(({ step, sign, label }) => (
        <button
          key={step}
          type="button"
          className="button button-small"
          aria-label={label}
          title={label}
          onClick={() => onStep(step)}
        >
          {sign}
        </button>
      ))}
      <button type="button" className="button button-small" onClick={() => onStep("whole")}>
        Full range
      </button>
    </div>
  );
}
