import { useId, type ReactNode } from "react";

interface Props {
  title: string;
  /** Beside the title: buttons, links. */
  actions?: ReactNode;
  /** What addresses with "#…" lead to. */
  id?: string;
  children: ReactNode;
}

/** A titled part of a page. */
export function Card({ title, actions, id, children }: Props) {
  const heading = useId();
  return (
    <section className="card" id={id} aria-labelledby={heading}>
      <header className="card-head">
        <h2 id={heading}>{title}</h2>
        {actions && <div className="card-actions">{actions}</div>}
      </header>
      {children}
    </section>
  );
}
