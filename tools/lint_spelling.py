"""Hold every text file to American spelling.

python tools/lint_spelling.py    fail at each British word

Words inside identifiers count, too (`center_of`, `isNormalized`). What another program spells
otherwise goes into ALLOWED, with the program's name.
"""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]

# This list and its tests are British on purpose; licenses are quoted to the letter.
SKIPPED = ("tools/lint_spelling.py", "tests/package/test_lints.py")
SKIPPED_PREFIX = "LICENSE"

# Spelled so by somebody else: the word, in lower case, and whose it is.
ALLOWED: dict[str, str] = {"neighbours": "healpy.get_all_neighbours"}

# -our, -ours, -oured, -ouring, -ourable ... for -or
OUR = """arbour ardour armour behaviour candour clamour colour demeanour endeavour favour fervour
flavour harbour honour humour labour neighbour odour parlour rancour rigour rumour saviour savour
splendour succour tumour valour vapour vigour misbehaviour discolour"""
# -re for -er
RE = """calibre centre epicentre fibre litre lustre manoeuvre meagre metre centimetre kilometre
micrometre millimetre nanometre mitre ochre reconnoitre sabre sceptre sombre spectre theatre"""
# -ise, -ised, -ising, -isation ... for -ize
ISE = """alphabet apolog amort antagon author bapt brutal burglar capital categor central character
civil colon commercial computer conceptual criminal critic crystall custom decentral demon denormal
depolar digit discret dramat econom emphas energ equal external factor familiar fantas fertil final
finger formal fossil fraternal general global harmon homogen hospital human hypnot hypothes ideal
idol immobil immortal immun individual industrial initial internal international ion ital item
jeopard journal legal lexical linear local magnet material maxim mechan memor metabol miniatur
minim mobil modern monopol moral motor national natural neutral normal notar optim organ orthogonal
orthonormal parallel parametr parameter patron penal personal philosoph plagiar polar polem
political popular pressur priorit privat prior public pulver quant radical random raster rational
real recogn regional regular renormal reorgan rhapsod romantic satir scandal scrutin secular sensit
sensational serial signal social special stabil standard steril stigmat subsid summar symbol
symmetr sympath synchron synthes systemat tantal temporal terror theor token topical total traumat
trivial tyrann uncategor util vandal vapor vector verbal victim visual vital vocal vulcan
western"""
# -ll- before -ed, -ing, -er, -able for -l-
DOUBLE = """barrel bevel cancel carol channel chisel counsel dial dishevel duel enamel equal
flannel fuel funnel gambol gravel grovel initial jewel label level libel marshal marvel medal metal
model multilevel panel parcel pedal pencil quarrel rational relabel remodel revel rival shovel
shrivel signal snivel spiral squirrel stencil swivel symbol tinsel total towel travel trowel tunnel
unravel unlabel vial weasel"""
WORDS = """acknowledgement acknowledgements ageing aluminium amongst analogue analogues
anticlockwise artefact artefacts backwards forwards afterwards towards upwards downwards inwards
outwards burnt catalogue catalogues catalogued cataloguing cheque cheques counsellor defence
defences offence offences pretence licence licences distil distils draught dreamt enrol enrols
enrolment fulfil fulfils fulfilment gaol grey greys greyed greyscale instalment instalments
jewellery judgement judgements kerb leant leapt learnt maths mould moulds moulded moult moustache
oestrogen orientated disorientated paediatric plough ploughed practise practised practises
practising programme programmes pyjamas sceptic sceptical sceptics skilful spelt spilt spoilt
storey storeys sulphur tyre tyres unlearnt unburnt whilst wilful woollen"""


def stems(text: str, ending: str = "") -> str:
    """Return a pattern for the words of a list, without an ending that all have."""
    return "|".join(word.removesuffix(ending) for word in text.split())


BRITISH = re.compile(
    rf"""(?:(?:re|un|non|multi|sub|pre|over|mis|dis|de)?(?:
      (?:{stems(OUR)})\w*
    | (?:{stems(RE)})(?:s|d)?
    | (?:{stems(RE, "re")})ring
    | (?:{stems(ISE)})is(?:e|es|ed|ing|ers?|ation|ations|able|ability)
    | (?:anal|catal|dial|electrol|hydrol|paral|reanal)ys(?:e|ed|ing|er|ers|able)
    | (?:{stems(DOUBLE)})l(?:ed|ing|ings|er|ers|able)
    | {stems(WORDS)}
    ))""",
    re.VERBOSE,
)
# A run of letters, cut where a capital begins a new word.
WORD = re.compile(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])")
# Two words in British English, one in American.
PHRASES = re.compile(r"\bper cent\b", re.IGNORECASE)


def british(line: str) -> list[str]:
    """Return the British words of a line."""
    found = []
    for match in WORD.finditer(line):
        word = match.group().lower()
        if BRITISH.fullmatch(word) and word not in ALLOWED:
            found.append(match.group())
    return found + PHRASES.findall(line)


def files() -> list[Path]:
    """Return the text files that git knows."""
    command = ["git", "ls-files", "--cached", "--others", "--exclude-standard", "-z"]
    run = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    names = [n for n in run.stdout.split("\0") if n and n not in SKIPPED]
    names = [n for n in names if not Path(n).name.startswith(SKIPPED_PREFIX)]
    paths = [ROOT / n for n in names]
    return [p for p in paths if p.is_file() and b"\0" not in p.read_bytes()[:8192]]


def main() -> int:
    said = []
    for path in files():
        try:
            text = path.read_text(encoding="utf-8")
        except UnicodeDecodeError:
            continue  # an image or another program's data
        for number, line in enumerate(text.splitlines(), 1):
            said += [f"{path.relative_to(ROOT)}:{number}: {word}" for word in british(line)]
    for line in said:
        print(line, file=sys.stderr)
    return 1 if said else 0


if __name__ == "__main__":
    raise SystemExit(main())
