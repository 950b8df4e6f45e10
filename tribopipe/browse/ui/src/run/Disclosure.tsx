import { useState, type ReactNode } from "react";

import { usePrinting } from "../shell/printing";

interface Props {
  title: ReactNode;
  /** Whether it belongs on paper though nobody opened it. */
  printed?: boolean;
  /** Made only once it is opened. */
  children: () => ReactNode;
}

/** What is shown when it is asked for. */
export function Disclosure({ title, printed = true, children }: Props) {
  const [chosen, setOpen] = useState(false);
  const open = (usePrinting() && printed) || chosen;
  return (
    <details className="disclosure" open={open} onToggle={(event) => setOpen(event.currentTarget.open)}>
      <summary>{title}</summary>
      {open && children()}
    </details>
  );
}
