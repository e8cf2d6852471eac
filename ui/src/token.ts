/** The right of the page. */

const TOKEN = "rtgen.token";

/** The token of the page's address, which the address bar and the history do not keep. */
export function token(): string {
  const given = new URLSearchParams(location.search).get("token");
  try {
    if (given === null) return sessionStorage.getItem(TOKEN) ?? "";
    sessionStorage.setItem(TOKEN, given);
  } catch {
    return given ?? ""; // without storage, the token stays in the address
  }
  history.replaceState(null, "", location.pathname + location.hash);
  return given;
}
