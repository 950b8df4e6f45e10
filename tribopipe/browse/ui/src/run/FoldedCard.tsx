import { useEffect, useRef, useState, type ReactNode } from "react";

import { usePrinting } from "../shell/printing";

interface Props {
  title: string;
  /** What addresses with "#…" lead to, and open. */
  id: string;
  /** Whether it is open at first. */
  open?: boolean;
  /** Made once it is opened. */
  children: () => ReactNode;
}

/** A titled part of a page that is opened by its title, by an address that leads to it, and for printing. */
export function FoldedCard({ title, id, open: atFirst = false, children }: Props) {
  const card = useRef<HTMLDetailsElement>(null);
  const [chosen, choose] = useState(atFirst);
  const open = usePrinting() || chosen;

  useEffect(() => {
    const openIfAsked = () => {
      if (location.hash !== `#${id}`) return;
      choose(true);
      card.current!.scrollIntoView();
    };
    openIfAsked();
    window.addEventListener("hashchange", openIfAsked);
    return () => window.removeEventListener("hashchange", openIfAsked);
  }, [id]);

  return (
    <details
      className="card folded"
      id={id}
      ref={card}
      open={open}
      onToggle={(event) => choose(event.currentTarget.open)}
    >
      <summary className="folded-head">
        <h2>{title}</h2>
      </summary>
      {open && children()}
    </details>
  );
}
