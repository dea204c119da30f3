import type { ReactNode } from "react";

// A table that may be wider than the page: it alone scrolls sideways, by keyboard too.
export function Scroll({ label, tall, children }: { label: string; tall?: boolean; children: ReactNode }) {
  return <div className={`scroll${tall ? " tall" : ""}`} tabIndex={0} role="group" aria-label={label}>{children}</div>;
}
