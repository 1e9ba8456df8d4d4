/* labels.c: words as triangles: each stroke of a letter becomes a thin rectangle. The strokes are
 * Futura light of the Hershey Fonts.
 *
 * The Hershey Fonts were originally created by Dr. A. V. Hershey while working at the U. S.
 * National Bureau of Standards. The format of the font data in this distribution was originally
 * created by James Hurt, Cognition, Inc., 900 Technology Park Drive, Billerica, MA 01821
 * (mit-eddie!ci-dandelion!hurt). They may be used by anyone for any purpose, commercial or
 * otherwise, provided that these acknowledgements are distributed with the font data; the data may
 * be converted into any format except the one distributed by the U.S. NTIS.
 *
 * A glyph is pairs of letters, each a number as its distance from R: first its left and right
 * border, then points, x to the right and y downwards; " R" lifts the pen. Capitals stand from -12
 * to 9. */
#include "acid/acid.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { FIRST_GLYPH = 32, GLYPHS = 95, GLYPH_TOP = -12, GLYPH_BOTTOM = 9 };

static const char *const glyphs[GLYPHS] = {
    "JZ",
    "MWRFRT RRYQZR[SZRY",
    "JZNFNM RVFVM",
    "H]SBLb RYBRb RLOZO RKUYU",
    "H\\PBP_ RTBT_ RYIWGTFPFMGKIKKLMMNOOUQWRXSYUYXWZT[P[MZKX",
    "F^[FI[ RNFPHPJOLMMKMIKIIJGLFNFPGSHVHYG[F RWTUUTWTYV[X[ZZ[X[VYTWT",
    "E_\\O\\N[MZMYNXPVUTXRZP[L[JZIYHWHUISJRQNRMSKSIRGPFNGMIMKNNPQUXWZY[[[\\Z\\Y",
    "MWRHQGRFSGSIRKQL",
    "KYVBTDRGPKOPOTPYR]T`Vb",
    "KYNBPDRGTKUPUTTYR]P`Nb",
    "JZRLRX RMOWU RWOMU",
    "E_RIR[ RIR[R",
    "NVSWRXQWRVSWSYQ[",
    "E_IR[R",
    "NVRVQWRXSWRV",
    "G][BIb",
    "H\\QFNGLJKOKRLWNZQ[S[VZXWYRYOXJVGSFQF",
    "H\\NJPISFS[",
    "H\\LKLJMHNGPFTFVGWHXJXLWNUQK[Y[",
    "H\\MFXFRNUNWOXPYSYUXXVZS[P[MZLYKW",
    "H\\UFKTZT RUFU[",
    "H\\WFMFLOMNPMSMVNXPYSYUXXVZS[P[MZLYKW",
    "H\\XIWGTFRFOGMJLOLTMXOZR[S[VZXXYUYTXQVOSNRNOOMQLT",
    "H\\YFO[ RKFYF",
    "H\\PFMGLILKMMONSOVPXRYTYWXYWZT[P[MZLYKWKTLRNPQOUNWMXKXIWGTFPF",
    "H\\XMWPURRSQSNRLPKMKLLINGQFRFUGWIXMXRWWUZR[P[MZLX",
    "NVROQPRQSPRO RRVQWRXSWRV",
    "NVROQPRQSPRO RSWRXQWRVSWSYQ[",
    "F^ZIJRZ[",
    "E_IO[O RIU[U",
    "F^JIZRJ[",
    "I[LKLJMHNGPFTFVGWHXJXLWNVORQRT RRYQZR[SZRY",
    ("E`WNVLTKQKOLNMMPMSNUPVSVUUVS RQKOMNPNSOUPV "
     "RWKVSVUXVZV\\T]Q]O\\L[JYHWGTFQFNGLHJJILHOHRIUJWLYNZQ[T[WZYYZX RXKWSWUXV"),
    "I[RFJ[ RRFZ[ RMTWT",
    "G\\KFK[ RKFTFWGXHYJYLXNWOTP RKPTPWQXRYTYWXYWZT[K[",
    "H]ZKYIWGUFQFOGMILKKNKSLVMXOZQ[U[WZYXZV",
    "G\\KFK[ RKFRFUGWIXKYNYSXVWXUZR[K[",
    "H[LFL[ RLFYF RLPTP RL[Y[",
    "HZLFL[ RLFYF RLPTP",
    "H]ZKYIWGUFQFOGMILKKNKSLVMXOZQ[U[WZYXZVZS RUSZS",
    "G]KFK[ RYFY[ RKPYP",
    "NVRFR[",
    "JZVFVVUYTZR[P[NZMYLVLT",
    "G\\KFK[ RYFKT RPOY[",
    "HYLFL[ RL[X[",
    "F^JFJ[ RJFR[ RZFR[ RZFZ[",
    "G]KFK[ RKFY[ RYFY[",
    "G]PFNGLIKKJNJSKVLXNZP[T[VZXXYVZSZNYKXIVGTFPF",
    "G\\KFK[ RKFTFWGXHYJYMXOWPTQKQ",
    "G]PFNGLIKKJNJSKVLXNZP[T[VZXXYVZSZNYKXIVGTFPF RSWY]",
    "G\\KFK[ RKFTFWGXHYJYLXNWOTPKP RRPY[",
    "H\\YIWGTFPFMGKIKKLMMNOOUQWRXSYUYXWZT[P[MZKX",
    "JZRFR[ RKFYF",
    "G]KFKULXNZQ[S[VZXXYUYF",
    "I[JFR[ RZFR[",
    "F^HFM[ RRFM[ RRFW[ R\\FW[",
    "H\\KFY[ RYFK[",
    "I[JFRPR[ RZFRP",
    "H\\YFK[ RKFYF RK[Y[",
    "KYOBOb RPBPb ROBVB RObVb",
    "KYKFY^",
    "KYTBTb RUBUb RNBUB RNbUb",
    "JZRDJR RRDZR",
    "I[Ib[b",
    "NVSKQMQORPSORNQO",
    "I\\XMX[ RXPVNTMQMONMPLSLUMXOZQ[T[VZXX",
    "H[LFL[ RLPNNPMSMUNWPXSXUWXUZS[P[NZLX",
    "I[XPVNTMQMONMPLSLUMXOZQ[T[VZXX",
    "I\\XFX[ RXPVNTMQMONMPLSLUMXOZQ[T[VZXX",
    "I[LSXSXQWOVNTMQMONMPLSLUMXOZQ[T[VZXX",
    "MYWFUFSGRJR[ ROMVM",
    "I\\XMX]W`VaTbQbOa RXPVNTMQMONMPLSLUMXOZQ[T[VZXX",
    "I\\MFM[ RMQPNRMUMWNXQX[",
    "NVQFRGSFREQF RRMR[",
    "MWRFSGTFSERF RSMS^RaPbNb",
    "IZMFM[ RWMMW RQSX[",
    "NVRFR[",
    "CaGMG[ RGQJNLMOMQNRQR[ RRQUNWMZM\\N]Q][",
    "I\\MMM[ RMQPNRMUMWNXQX[",
    "I\\QMONMPLSLUMXOZQ[T[VZXXYUYSXPVNTMQM",
    "H[LMLb RLPNNPMSMUNWPXSXUWXUZS[P[NZLX",
    "I\\XMXb RXPVNTMQMONMPLSLUMXOZQ[T[VZXX",
    "KXOMO[ ROSPPRNTMWM",
    "J[XPWNTMQMNNMPNRPSUTWUXWXXWZT[Q[NZMX",
    "MYRFRWSZU[W[ ROMVM",
    "I\\MMMWNZP[S[UZXW RXMX[",
    "JZLMR[ RXMR[",
    "G]JMN[ RRMN[ RRMV[ RZMV[",
    "J[MMX[ RXMM[",
    "JZLMR[ RXMR[P_NaLbKb",
    "J[XMM[ RMMXM RM[X[",
    "KYTBRCQDPFPHQJRKSMSOQQ RRCQEQGRISJTLTNSPORSTTVTXSZR[Q]Q_Ra RQSSUSWRYQZP\\P^Q`RaTb",
    "NVRBRb",
    "KYPBRCSDTFTHSJRKQMQOSQ RRCSESGRIQJPLPNQPURQTPVPXQZR[S]S_Ra RSSQUQWRYSZT\\T^S`RaPb",
    "F^IUISJPLONOPPTSVTXTZS[Q RISJQLPNPPQTTVUXUZT[Q[O",
};

enum { MOST_STROKES = 65535 / 4 };

static const char *glyph_of_letter(char letter) {
    const int index = (unsigned char)letter - FIRST_GLYPH;
    return glyphs[index >= 0 && index < GLYPHS ? index : '?' - FIRST_GLYPH];
}

static double letter_unit(double size) { return size / (GLYPH_BOTTOM - GLYPH_TOP); }

static double words_width(const char *text, size_t length, double size) {
    double units = 0;
    for (size_t i = 0; i < length; ++i) {
        const char *glyph = glyph_of_letter(text[i]);
        units += glyph[1] - glyph[0];
    }
    return units * letter_unit(size);
}

static int make_room(acid_ink *ink) {
    if (ink->strokes < ink->capacity) return 1;
    const size_t capacity = ink->capacity ? 2 * ink->capacity : 256;
    float *positions = realloc(ink->positions, capacity * 12 * sizeof *positions);
    if (positions) ink->positions = positions;
    uint16_t *indices = realloc(ink->indices, capacity * 6 * sizeof *indices);
    if (indices) ink->indices = indices;
    ink->failed |= !positions || !indices || ink->strokes == MOST_STROKES;
    if (!ink->failed) ink->capacity = capacity;
    return !ink->failed;
}

/* Both ends reach half a width further, so that strokes meet. */
static void add_stroke(acid_ink *ink, const double a[2], const double b[2], double half) {
    const double dx = b[0] - a[0], dy = b[1] - a[1], length = sqrt(dx * dx + dy * dy);
    if (!(length > 0) || !make_room(ink)) return;
    const double ux = half * dx / length, uy = half * dy / length;
    const double corners[4][2] = {{a[0] - ux + uy, a[1] - uy - ux},
        {b[0] + ux + uy, b[1] + uy - ux}, {b[0] + ux - uy, b[1] + uy + ux},
        {a[0] - ux - uy, a[1] - uy + ux}};
    static const uint16_t order[6] = {0, 1, 2, 0, 2, 3};
    for (size_t i = 0; i < 4; ++i) {
        float *to = ink->positions + 12 * ink->strokes + 3 * i;
        to[0] = (float)corners[i][0];
        to[1] = (float)corners[i][1];
        to[2] = 0;
    }
    for (size_t i = 0; i < 6; ++i)
        ink->indices[6 * ink->strokes + i] = (uint16_t)(4 * ink->strokes + order[i]);
    ++ink->strokes;
}

static void write_letter(acid_ink *ink, const char *glyph, double x, double y, double size) {
    const double unit = letter_unit(size), half = 0.055 * size;
    double last[2] = {0, 0};
    int down = 0;
    for (const char *at = glyph + 2; at[0] && at[1]; at += 2) {
        if (at[0] == ' ') {
            down = 0;
            continue;
        }
        const double point[2] = {
            x + (at[0] - glyph[0]) * unit, y - (at[1] - 'R' - GLYPH_BOTTOM) * unit};
        if (down) add_stroke(ink, last, point, half);
        memcpy(last, point, sizeof last);
        down = 1;
    }
}

void acid_write_lines(
    acid_ink *ink, const char *text, double x, double y, double size, double width) {
    while (*text) {
        size_t taken = 0;
        double at = x;
        for (size_t i = 1; i <= strlen(text); ++i)
            if ((!text[i] || text[i - 1] == '-') && (!taken || words_width(text, i, size) <= width))
                taken = i;
        for (; taken; --taken, ++text) {
            write_letter(ink, glyph_of_letter(*text), at, y, size);
            at += words_width(text, 1, size);
        }
        y -= 1.45 * size;
    }
}
