// The token: typed, or brought by the address's fragment; kept no longer than this tab is open.

import { plain } from "./text.js";

const KEY = "dh-drone-token";
const ROLES = ["command", "view"];

/** Return { token, role } of a fragment such as #token=...&role=view, null if it has none. */
export function fromFragment(fragment) {
  const fields = new URLSearchParams(fragment.replace(/^#/, ""));
  const token = fields.get("token");
  const role = fields.get("role") ?? "command";
  return token && ROLES.includes(role) ? { token, role } : null;
}

export class Tokens {
  /** given: is called with { token, role } when somebody typed one. */
  constructor(given) {
    this.dialog = document.getElementById("login");
    this.dialog.addEventListener("cancel", (event) => event.preventDefault());
    this.dialog.querySelector("form").addEventListener("submit", () => {
      const token = document.getElementById("token");
      const role = this.dialog.querySelector("[name=role]:checked").value;
      const credentials = { token: token.value.trim(), role };
      token.value = "";
      sessionStorage.setItem(KEY, JSON.stringify(credentials));
      given(credentials);
    });
  }

  /** Return what is known without asking; a fragment is taken out of the address at once. */
  kept() {
    const brought = fromFragment(location.hash);
    if (brought) {
      history.replaceState(null, "", location.pathname);
      sessionStorage.setItem(KEY, JSON.stringify(brought));
      return brought;
    }
    return JSON.parse(sessionStorage.getItem(KEY) ?? "null");
  }

  ask(said) {
    sessionStorage.removeItem(KEY);
    document.getElementById("login-said").textContent = plain(said);
    if (!this.dialog.open) this.dialog.showModal();
  }

  close() {
    if (this.dialog.open) this.dialog.close();
  }
}
