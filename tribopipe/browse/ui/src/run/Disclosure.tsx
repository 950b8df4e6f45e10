import { useState, type ReactNode } from "react";

import { usePrinting } from "../shell/printing";

interface Props {
  title: ReactNode;
  /** Made only once it is opened. */
  children: () => ReactNode;
}

/** What is shown when it is asked for. */
export function Disclosure({ title, children }: Props) {
  const [chosen, setOpen] = useState(false);
  const open = usePrinting() || chosen;
  return (
    <details className="disclosure" open={open} onToggle={(event) => setOpen(event.currentTarget.open)}>
      <summary>{title}</summary>
      {open && children()}
    </details>
  );
}
