// @ts-check
/** Requests to the console's server. */

/** A request that was not done, with a reason for the operator. */
export class RequestError extends Error {
  /**
   * @param {string} code
   * @param {string} message
   */
  constructor(code, message) {
    super(message);
    this.code = code;
  }
}

/**
 * Send a request and return its answer.
 * @param {string} path
 * @param {object | null} body
 * @param {number} timeoutMs
 * @returns {Promise<any>} the decoded answer
 * @throws {RequestError}
 */
export async function post(path, body, timeoutMs) {
  const response = await send(path, body, timeoutMs);
  const answer = await response.json().catch(() => null);
  if (response.ok) return answer;
  throw new RequestError(answer?.code ?? "error", answer?.message ?? `the console answered ${response.status}`);
}

/**
 * Send a request and return the response, whatever its status.
 * @param {string} path
 * @param {object | null} body
 * @param {number} timeoutMs
 * @returns {Promise<Response>}
 * @throws {RequestError} when there is no response
 */
export async function send(path, body, timeoutMs) {
  try {
    return await fetch(path, {
      method: "POST",
      headers: body === null ? {} : { "Content-Type": "application/json" },
      body: body === null ? null : JSON.stringify(body),
      signal: AbortSignal.timeout(timeoutMs),
    });
  } catch (error) {
    const late = error instanceof DOMException && error.name === "TimeoutError";
    throw new RequestError(
      late ? "deadline" : "unavailable",
      late ? `no answer within ${timeoutMs / 1000} s` : "the console's server cannot be reached",
    );
  }
}
