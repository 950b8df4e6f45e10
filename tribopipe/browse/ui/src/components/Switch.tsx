interface Props {
  label: string;
  choices: { name: string; label: string }[];
  value: string;
  onChoose(name: string): void;
}

/** One of a few, all in sight. */
export function Switch({ label, choices, value, onChoose }: Props) {
  return (
    <div className="switch" role="group" aria-label={label}>
      {choices.map((choice) => (
        <button
          key={choice.name}
          type="button"
          aria-pressed={choice.name === value}
          onClick={() => onChoose(choice.name)}
        >
          {choice.label}
        </button>
      ))}
    </div>
  );
}
