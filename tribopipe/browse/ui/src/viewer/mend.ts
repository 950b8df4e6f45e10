/** Put right roles in h5web 17 that mean nothing to a screen reader: choices called tabs, tabs outside any list. */
export function mendRoles(box: HTMLElement): void {
  for (const choice of box.querySelectorAll('[role="tab"][aria-checked]')) {
    choice.setAttribute("role", "radio");
    choice.closest('[role="tablist"]')?.setAttribute("role", "radiogroup");
  }
  for (const tab of box.querySelectorAll('[role="tab"]')) {
    if (tab.closest('[role="tablist"]') === null) tab.parentElement?.setAttribute("role", "tablist");
  }
}
