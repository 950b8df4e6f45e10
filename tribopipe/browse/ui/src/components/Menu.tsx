import { useEffect, useId, useRef, useState, type FocusEvent, type KeyboardEvent, type ReactNode } from "react";

/** A button that opens a panel; Escape and going elsewhere, by key or pointer, close it. */
export function Menu({ label, children }: { label: string; children: ReactNode }) {
  const [open, setOpen] = useState(false);
  const panel = useId();
  const menu = useRef<HTMLDivElement>(null);
  const button = useRef<HTMLButtonElement>(null);
  const isOutside = (target: EventTarget | null) => target instanceof Node && !menu.current?.contains(target);

  useEffect(() => {
    if (!open) return;
    const closeOnPress = (event: PointerEvent) => {
      if (isOutside(event.target)) setOpen(false);
    };
    document.addEventListener("pointerdown", closeOnPress);
    return () => document.removeEventListener("pointerdown", closeOnPress);
  }, [open]);

  const closeOnEscape = (event: KeyboardEvent) => {
    if (event.key !== "Escape" || !open) return;
    setOpen(false);
    button.current?.focus();
  };
  const closeOnLeave = (event: FocusEvent) => {
    if (isOutside(event.relatedTarget)) setOpen(false);
  };

  return (
    <div className="menu" ref={menu} onKeyDown={closeOnEscape} onBlur={closeOnLeave}>
      <button
        ref={button}
        type="button"
        className="button"
        aria-expanded={open}
        aria-controls={open ? panel : undefined}
        onClick={() => setOpen(!open)}
      >
        {label} <span aria-hidden="true">▾</span>
      </button>
      {open && (
        // Takes the focus of a press between its parts, which counted as going elsewhere otherwise.
        <div className="menu-panel" id={panel} tabIndex={-1}>
          {children}
        </div>
      )}
    </div>
  );
}
