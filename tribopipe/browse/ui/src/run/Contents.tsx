import { useEffect, useState } from "react";

export interface Section {
  id: string;
  title: string;
}

/** The parts of a page, at its side where there is room. */
export function Contents({ sections }: { sections: Section[] }) {
  const current = useInSight(sections.map(({ id }) => id).join(" "));
  return (
    <nav className="contents" aria-label="On this page">
      <ul>
        {sections.map(({ id, title }) => (
          <li key={id}>
            <a href={`#${id}`} aria-current={id === current ? "location" : undefined}>
              {title}
            </a>
          </li>
        ))}
      </ul>
    </nav>
  );
}

/** Which part is at the top of the window; ids are separated by spaces. */
function useInSight(ids: string): string | null {
  const [current, setCurrent] = useState<string | null>(null);
  useEffect(() => {
    const seen = new Set<string>();
    const observer = new IntersectionObserver(
      (entries) => {
        for (const { target, isIntersecting } of entries) seen[isIntersecting ? "add" : "delete"](target.id);
        setCurrent((before) => ids.split(" ").find((id) => seen.has(id)) ?? before);
      },
      { rootMargin: "-12% 0px -65% 0px" },
    );
    for (const id of ids.split(" ")) {
      const part = document.getElementById(id);
      if (part) observer.observe(part);
    }
    return () => observer.disconnect();
  }, [ids]);
  return current;
}
