import { useCallback, useEffect, useRef, useState } from "react";

export type Connection = "connecting" | "open" | "lost";

// Server-sent events of /api/events while the component is shown. The browser connects
// again by itself and asks for what it missed.
export function useEvents(handlers: Record<string, (data: never) => void>): Connection {
  const [connection, setConnection] = useState<Connection>("connecting");
  const current = useRef(handlers);
  current.current = handlers;
  const names = Object.keys(handlers).sort().join(" ");
  useEffect(() => {
    let source: EventSource;
    let again = 0;
    const listen = () => {
      source = new EventSource("/api/events");
      source.onopen = () => setConnection("open");
      source.onerror = () => {
        setConnection("lost");
        // The browser gives up for good where the answer was a refusal.
        if (source.readyState === EventSource.CLOSED) again = window.setTimeout(listen, 2000);
      };
      for (const name of names.split(" ")) {
        source.addEventListener(name, (event) => {
          current.current[name]?.(JSON.parse((event as MessageEvent<string>).data) as never);
        });
      }
    };
    listen();
    return () => { clearTimeout(again); source.close(); };
  }, [names]);
  return connection;
}

// Events come in their order; an answer to a request may come late, after an event or an
// answer to a later request. What is begun with this gets a number, and says when it comes
// whether it is still news: nothing that was begun later has come.
export function useNews(): () => () => boolean {
  const last = useRef({ begun: 0, came: 0 });
  return useCallback(() => {
    const mine = ++last.current.begun;
    return () => {
      if (mine < last.current.came) return false;
      last.current.came = mine;
      return true;
    };
  }, []);
}
