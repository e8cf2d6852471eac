/** Texts of the page in the language of its reader: written in English where they are shown, translated by the catalogue of the server. */

/** The languages of the page, as each calls itself. */
export const LANGUAGES = { en: "English", ja: "日本語" } as const;
export type Language = keyof typeof LANGUAGES;

/** The language that was chosen on this page. */
const CHOSEN = "rtgen language";

const isLanguage = (name: string | null): name is Language => name !== null && Object.hasOwn(LANGUAGES, name);

/** The chosen language, else that of the server, which has written it into the page; English outside of a browser. */
function current(): Language {
  if (typeof document === "undefined") return "en";
  const of = document.documentElement;
  try {
    const chosen = localStorage.getItem(CHOSEN);
    if (isLanguage(chosen)) of.lang = chosen;
  } catch {
    // without storage, the page is in the server's language
  }
  return isLanguage(of.lang) ? of.lang : "en";
}

export const language = current();

async function catalogue(): Promise<Readonly<Record<string, string>>> {
  if (language === "en") return {};
  try {
    const answer = await fetch(`texts/${language}.json`);
    return answer.ok ? ((await answer.json()) as Record<string, string>) : {};
  } catch {
    return {}; // the server has ended; the page says so in English
  }
}

/** The translations by English texts. What imports this waits for them, so constants of modules can be texts, too. */
const texts = await catalogue();

/** Shows the page in another language. */
function choose(wanted: Language): void {
  try {
    localStorage.setItem(CHOSEN, wanted);
  } catch {
    return; // without storage, there is nothing to remember it by
  }
  location.reload();
}

/** What a menu of languages offers: those that the page is not in. */
export const languages = (): { name: string; act: () => void }[] =>
  (Object.keys(LANGUAGES) as Language[]).filter((each) => each !== language).map((each) => ({ name: LANGUAGES[each], act: () => choose(each) }));

/** The place of a value, `{count}`, or of words by a number, `{count:call|calls}`: the first ones for 1, else the others. */
const PLACE = /\{(\w+(?::[^{}|]*\|[^{}|]*)?)\}/;

/** A text in the reader's language, with each name of a value mapped between the texts around it. */
export const filled = <T>(english: string, value: (name: string) => T): (string | T)[] =>
  (texts[english] ?? english).split(PLACE).map((each, i) => {
    if (i % 2 === 0) return each;
    const [name, one, others] = each.split(/[:|]/) as [string, string?, string?];
    if (others === undefined) return value(name);
    return String(value(name)) === "1" ? one! : others;
  });

/** A text, with values in the places of their names: `t("{count} {count:call|calls}", { count })`. */
export const t = (english: string, values: Readonly<Record<string, string | number | bigint>> = {}): string =>
  filled(english, (name) => String(values[name])).join("");
