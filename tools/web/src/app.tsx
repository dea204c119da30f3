import { lazy, Suspense, useEffect, useState } from "react";
import { answered, api, type Schemas } from "./api/client";
import { StopCorner, StopNote } from "./ui/emergency";
import { Busy } from "./ui/parts";

// One page each, fetched when it is first opened. `moves`: a machine is moved or watched there.
const pages = [
  { path: "/diagnose", name: "Diagnose", moves: false, page: lazy(() => import("./pages/diagnose")) },
  { path: "/calibrate", name: "Calibrate", moves: true, page: lazy(() => import("./pages/calibrate")) },
  { path: "/bed", name: "Bed", moves: true, page: lazy(() => import("./pages/bed")) },
  { path: "/machine", name: "Machine", moves: true, page: lazy(() => import("./pages/machine")) },
];

function NotFound() {
  return (
    <>
      <h1>There is no such page</h1>
      <p>The address <code>{location.pathname}</code> leads nowhere. The pages are named above.</p>
    </>
  );
}

export function App() {
  const [path, setPath] = useState(location.pathname);
  const [about, setAbout] = useState<Schemas["About"] | null>(null);
  useEffect(() => {
    const follow = () => setPath(location.pathname);
    addEventListener("popstate", follow);
    answered(api.GET("/api")).then(setAbout, () => setAbout(null));
    return () => removeEventListener("popstate", follow);
  }, []);
  const shown = ["/", "/index.html"].includes(path) ? pages[0] : pages.find((one) => one.path === path);
  const name = shown?.name ?? "No such page";
  useEffect(() => {
    document.title = `${name} · caltwin`;
  }, [name]);
  const open = (to: string) => (event: React.MouseEvent) => {
    if (event.metaKey || event.ctrlKey) return;
    event.preventDefault();
    history.pushState(null, "", to);
    setPath(to);
    document.getElementById("main")?.focus();
  };
  const Page = shown?.page ?? NotFound;
  return (
    <div className={shown?.moves ? "has-stop" : undefined}>
      <a className="skip" href="#main">Skip to content</a>
      <header>
        <span className="brand">caltwin</span>
        <nav aria-label="Pages">
          {pages.filter((one) => one.path !== "/bed" || about?.has_bed !== false).map((one) => (
            <a key={one.path} href={one.path} onClick={open(one.path)}
               aria-current={one === shown ? "page" : undefined}>{one.name}</a>
          ))}
        </nav>
        <span className="version">{about ? `version ${about.version}` : ""}</span>
      </header>
      {shown?.moves ? <StopCorner /> : null}
      <main id="main" tabIndex={-1}>
        {shown?.moves ? <StopNote /> : null}
        <Suspense fallback={<Busy text="Loading the page" />}>
          <Page />
        </Suspense>
      </main>
    </div>
  );
}
