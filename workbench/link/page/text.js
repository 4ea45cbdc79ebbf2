// Text from others: it changes neither the order of letters nor the layout of the page.

export const LONGEST = 300;
const ACTING = /(?![\u200c\u200d])[\p{Cc}\p{Cf}\p{Cs}\p{Zl}\p{Zp}]/gu; // but the joiners of letters

/** Return a text as one line of limited length, with escapes for what is not seen itself. */
export function plain(text, longest = LONGEST) {
  const whole = String(text);
  const shown = whole.slice(0, longest).replace(ACTING, (each) => {
    const code = each.codePointAt(0);
    return code < 0x10000 ? `\\u${hex(code, 4)}` : `\\u{${hex(code, 1)}}`;
  });
  return whole.length > longest ? `${shown}… (${whole.length} characters)` : shown;
}

function hex(code, digits) {
  return code.toString(16).padStart(digits, "0");
}
