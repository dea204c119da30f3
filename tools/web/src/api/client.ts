// The REST interface, typed by docs/openapi.json, from which the build makes schema.d.ts.
import createClient from "openapi-fetch";
import type { components, paths } from "./schema";

export type Schemas = components["schemas"];
export type Problem = Schemas["Problem"] & { held_by?: string };

export const api = createClient<paths>({ baseUrl: "", headers: { "X-Operator": operatorName() } });

// Who sits at this page, told to others who want to move the machine meanwhile.
export function operatorName(): string {
  const kept = localStorage.getItem("operator");
  if (kept) return kept;
  const name = `the page opened at ${new Date().toLocaleTimeString()}`;
  localStorage.setItem("operator", name);
  return name;
}

// What a request failed by, for people: always a Problem, also where nobody answered.
export function problemOf(error: unknown): Problem {
  if (error && typeof error === "object" && "detail" in error && "status" in error) {
    return error as Problem;
  }
  return {
    type: "about:blank",
    title: "No answer",
    status: 0,
    detail: "The server does not answer. Is caltwin serve still running?",
  };
}

// The answer, or the problem thrown.
export async function answered<T>(
  asked: Promise<{ data?: T; error?: unknown; response: Response }>,
): Promise<T> {
  const { data, error } = await asked.catch((fault: unknown) => ({ data: undefined, error: fault }));
  if (data === undefined) throw problemOf(error);
  return data;
}
