import { lazy, Suspense, useEffect, useRef, useState } from "react";
import { Busy, Card } from "../ui/parts";
import { isDrawable } from "./places";
import type { Diagnosis } from "./types";

const DrawnErrors = lazy(() => import("./drawn_errors"));

// The drawing in three dimensions is fetched when it comes into sight.
export function Drawn({ one, machine }: { one: Diagnosis; machine: string }) {
  const box = useRef<HTMLDivElement>(null);
  const [isNear, setNear] = useState(false);
  const drawable = isDrawable(one);
  useEffect(() => {
    if (!drawable || !box.current) return;
    const seen = new IntersectionObserver((all) => { if (all.some((each) => each.isIntersecting)) setNear(true); }, { rootMargin: "300px" });
    seen.observe(box.current);
    return () => seen.disconnect();
  }, [drawable]);
  if (!drawable) return null;
  return (
    <div ref={box}>
      <Card title="The error, drawn larger than it is">
        {isNear
          ? <Suspense fallback={<Busy text="Loading the drawing" />}><DrawnErrors one={one} machine={machine} /></Suspense>
          : <Busy text="The drawing loads when it comes into sight" />}
      </Card>
    </div>
  );
}
