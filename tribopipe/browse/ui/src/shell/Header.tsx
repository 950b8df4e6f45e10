import { useArchive } from "./archive";
import { Link } from "./router";
import { ThemeSwitch } from "./ThemeSwitch";

const PAGES = [
  { href: "/", label: "Runs", within: ["/", "/runs"] },
  { href: "/studies", label: "Studies", within: ["/studies"] },
  { href: "/scatter", label: "Scatter plot", within: ["/scatter"] },
  { href: "/compare", label: "Compare", within: ["/compare"] },
];

const isWithin = (path: string, part: string): boolean =>
  path === part || (part !== "/" && path.startsWith(`${part}/`));

/** Name of the archive and the way to its pages. */
export function Header({ path }: { path: string }) {
  const { answer: archive } = useArchive();
  return (
    <header className="top">
      <Link href="/" className="brand">
        <Mark />
        tribopipe
      </Link>
      <nav aria-label="Pages">
        {PAGES.map(({ href, label, within }) => (
          <Link key={href} href={href} aria-current={within.some((part) => isWithin(path, part)) ? "page" : undefined}>
            {label}
          </Link>
        ))}
      </nav>
      {archive && (
        <span className="archive-name" title={archive.folder}>
          {archive.name}
        </span>
      )}
      <ThemeSwitch />
    </header>
  );
}

/** A ball on a flat. */
function Mark() {
  return (
    <svg width="20" height="20" viewBox="0 0 20 20" aria-hidden="true">
      <circle cx="10" cy="7.5" r="5.5" fill="none" stroke="currentColor" strokeWidth="2" />
      <path d="M1 16h6.5q2.5-4 5 0H19" fill="none" stroke="currentColor" strokeWidth="2" />
    </svg>
  );
}
