import { useMemo } from "react";

import { useTheme } from "../shell/theme";

/** Gives the colour that a CSS variable of the theme stands for; another function once the theme changes. */
export function useColours(): (variable: string) => string {
  const theme = useTheme();
  return useMemo(() => {
    const style = getComputedStyle(document.documentElement);
    const known = new Map<string, string>();
    return (variable: string) => {
      if (!known.has(variable)) known.set(variable, style.getPropertyValue(variable).trim() || "gray");
      return known.get(variable)!;
    };
  }, [theme]);
}
