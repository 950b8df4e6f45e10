import type { Fact } from "../api";
import { unbroken } from "../run/words";

/** Names and values beside each other. */
export function Facts({ facts }: { facts: Fact[] }) {
  return (
    <dl className="facts">
      {facts.map(({ name, value }, index) => (
        <div key={index} className="fact">
          <dt>{name}</dt>
          <dd>{unbroken(value)}</dd>
        </div>
      ))}
    </dl>
  );
}
