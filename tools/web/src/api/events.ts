import { useEffect, useRef, useState } from "react";

export type Connection = "connecting" | "open" | "lost";

// Server-sent events of /api/events while the component is shown. The browser connects
// again by itself and asks for what it missed.
export function useEvents(handlers: Record<string, (data: never) => void>): Connection {
  const [connection, setConnection] = useState<Connection>("connecting");
  const current = useRef(handlers);
  current.current = handlers;
  const names = Object.keys(handlers).sort().join(" ");
  useEffect(() => {
    const source = new EventSource("/api/events");
    source.onopen = () => setConnection("open");
    source.onerror = () => setConnection("lost");
    for (const name of names.split(" ")) {
      source.addEventListener(name, (event) => {
        current.current[name]?.(JSON.parse((event as MessageEvent<string>).data) as never);
      });
    }
    return () => source.close();
  }, [names]);
  return connection;
}
