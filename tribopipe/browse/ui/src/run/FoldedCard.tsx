import { useEffect, useRef, useState, type ReactNode } from "react";
import { flushSync } from "react-dom";

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
  const [made, make] = useState(atFirst);

  useEffect(() => {
    const open = () => {
      flushSync(() => make(true));
      card.current!.open = true;
    };
    const openIfAsked = () => {
      if (location.hash !== `#${id}`) return;
      open();
      card.current!.scrollIntoView();
    };
    openIfAsked();
    window.addEventListener("hashchange", openIfAsked);
    window.addEventListener("beforeprint", open);
    return () => {
      window.removeEventListener("hashchange", openIfAsked);
      window.removeEventListener("beforeprint", open);
    };
  }, [id]);

  return (
    <details
      className="card folded"
      id={id}
      ref={card}
      open={atFirst}
      onToggle={(event) => event.currentTarget.open && make(true)}
    >
      <summary className="folded-head">
        <h2>{title}</h2>
      </summary>
      {made && children()}
    </details>
  );
}
