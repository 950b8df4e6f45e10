import { useState, type ReactNode } from "react";

interface Props {
  title: ReactNode;
  /** Made only once it is opened. */
  children: () => ReactNode;
}

/** What is shown when it is asked for. */
export function Disclosure({ title, children }: Props) {
  const [open, setOpen] = useState(false);
  return (
    <details className="disclosure" onToggle={(event) => setOpen(event.currentTarget.open)}>
      <summary>{title}</summary>
      {open && children()}
    </details>
  );
}
