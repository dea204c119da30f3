import type { components } from "./schema";

export type Schemas = components["schemas"];
export type Problem = Schemas["Problem"] & { held_by?: string };

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
