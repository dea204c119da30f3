// The REST interface, typed by docs/openapi.json, from which the build makes schema.d.ts.
import createClient from "openapi-fetch";
import { problemOf, type Problem, type Schemas } from "./problem";
import type { paths } from "./schema";

export { problemOf, type Problem, type Schemas };

export const api = createClient<paths>({ baseUrl: "", headers: { "X-Operator": operatorName() } });

// Who sits at this page, told to others who want to move the machine meanwhile.
export function operatorName(): string {
  const kept = localStorage.getItem("operator");
  if (kept) return kept;
  const name = `the page opened at ${new Date().toLocaleTimeString()}`;
  localStorage.setItem("operator", name);
  return name;
}

// The answer, or the problem thrown.
export async function answered<T>(
  asked: Promise<{ data?: T; error?: unknown; response: Response }>,
): Promise<T> {
  const { data, error } = await asked.catch((fault: unknown) => ({ data: undefined, error: fault }));
  if (data === undefined) throw problemOf(error);
  return data;
}
