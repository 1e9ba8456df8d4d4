/* outlines.h: the outlines of letters: Open Sans Regular, made by scripts/outlines.c.
 *
 * Digitized data copyright (c) 2010-2011, Google Corporation. Licensed under the Apache
 * License, Version 2.0 (the "License"); you may not use this file except in compliance with
 * the License. You may obtain a copy of the License at
 * http://www.apache.org/licenses/LICENSE-2.0
 * Unless required by applicable law or agreed to in writing, software distributed under the
 * License is distributed on an "AS IS" BASIS, WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND,
 * either express or implied. See the License for the specific language governing permissions
 * and limitations under the License.
 *
 * A glyph is a point, its advance, then m (to a point), l (a line to it) or q (a quadratic
 * curve by one to another). A point is two numbers, x to the right and y upwards; each has two
 * letters: digits from '#' without '?', to the base of RENDER_OUTLINE_BASE, less
 * RENDER_OUTLINE_OFFSET. */
#ifndef NORMA_RENDER_OUTLINES_H
#define NORMA_RENDER_OUTLINES_H
#include <stdint.h>

/* clang-format off */
enum {
    RENDER_FIRST_OUTLINE = 32,
    RENDER_OUTLINES = 95,
    RENDER_OUTLINE_BASE = 56,
    RENDER_OUTLINE_OFFSET = 700,
    RENDER_CAPITALS = 1462 /* their height */
};

static const char *const render_outlines[RENDER_OUTLINES] = {
    "9#/@",
    "92/@m556Kl3<6Kl2BJFl60JFl556Km2/19q2/3R473Rq593R5Y3.q6A2D6A19q6A015Y/Fq58.[47.[q3;.[2R/B"
        "q2/0)2/19",
    ">,/@m5.JFl4>A-l2FA-l1UJFl5.JFm;PJFl;&A-l9.A-l8=JFl;PJF",
    "H*/@mB$@Cl@S9>lEV9>lEV7-l@:7-l=W/@l;=/@l<Z7-l7C7-l6(/@l3I/@l5(7-l0:7-l0:9>l5B9>l6N@Cl1Q@"
        "Cl1QBRl7+BRl8FJFl;(JFl9GBRl@'BRlADJFlCZJFlB=BRlG-BRlG-@ClB$@Cm7[9>l=99>l>D@Cl9,@Cl7[9>",
    "E:/@mC#7AqC#5(A-3@q>71X;(1Al;(-8l8P-8l8P17q6P174W1Iq3%1[1S2Bl1S55q354I5140q7.3R8P3Rl8P;J"
        "q5*<S3H>8q2-@W2-C6q2-EJ3[G-q5QHJ8PI#l8PL1l;(L1l;(I%q>8HYB;GLlA@E8q=SF;;(FGl;(=Uq=V<[@3<*"
        "qAJ;3B6:-qC#9(C#7Am>Z73q>Z8D>,97q=8:,;(:Yl;(4#q>Z4B>Z73m5.C8q5.B$6#A.q6Q@88P>Hl8PFCq7$F2"
        "6)E;q5.DF5.C8",
    "NF/@m3RBRq3R>P4>=2q5+;N6G;Nq9C;N9CBRq9CHT6GHTq5+HT4>G7q3RET3RBRm<#BRq<#=N:G;Iq929E6G9Eq4"
        "*9E2M;Lq17=S17BRq17FU2JHXq4$J[6GJ[q9/J[:FHTq<#FM<#BRmDB77qDB44E.2PqET13G713qHT13ID2OqJ34"
        "2J377qJ3::ID;UqHT=7G7=7qET=7E.;UqDB::DB77mLM77qLM34K71/qJ#/+G7/+qDR/+C<12qB(39B(77qB(;:C"
        ":==qDN@AG7@AqIV@AK4=:qLM;5LM77mH*JFl8H/@l6$/@lE@JFlH*JF",
    "K./@m6VE:q6VD-7BC&q8-AY9M@8q<%AL<XBSq=SC[=SE=q=SFS<WGKq<#HD:=HDq8UHD7UGLq6VFT6VE:m9I1Qq="
        "Z1QAQ4Cl9#<*q7$:W6.:)q58954[8:q4E7@4E66q4E415Z3$q771Q9I1Qm1A62q1A8E2N:8q4#<,7/=[q5K@J5+A"
        "Cq4FB;43C8q3ZD53ZE6q3ZH$5LIAq7=K$:EK$q=>K$@+IAqAQH%AQE8qAQC=@EASq>8@0;D=DlCS6EqDS7KE;9-q"
        "F%:JF<<<lI<<<qH076EP4KlK*/@lG%/@lCM2JqAG0P></Zq<2/+9E/+q5N/+3G1%q1A2X1A62",
    "7E/@m5.JFl4>A-l2FA-l1UJFl5.JF",
    ":5/@m0Z9Aq0Z>126C8q3MG@66JFl90JFq6IG,57C%q4'=W4'9Cq4'52591-q6L-(9.)Ll66)Lq3L,N260Qq0Z4T0"
        "Z9A",
    ":5/@m8T9Aq8T4R7=0Oq6(,L3>)Ll0G)Lq3)-'4;1,q5N525N9Cq5N=W4<C%q3,G,0EJFl3>JFq6)G>7>C6q8T>/8"
        "T9A",
    "DJ/@m;0L3l:=E0lBDG/lC%CZl;0C:l@I<El<E:Wl9<B8l6E:Wl3<<El7OC:l1%CZl1CG/l8BE0l7OL3l;0L3",
    "E:/@m;,=GlCA=GlCA;,l;,;,l;,3Cl8J3Cl8J;,l17;,l17=Gl8J=Gl8JF2l;,F2l;,=G",
    "8=/@m5N3Nl6$36q5C1C4J/.q3Q,R2T*Pl0G*Pq1),H1J/8q222)2@3Nl5N3N",
    ";2/@m1#7Yl1#:Il9O:Il9O7Yl1#7Y",
    "90/@m2/19q2/2E2N3.q343R453Rq573R5X3.q6A2E6A19q6A005X/Fq56.[45.[q3:.[2Q/Bq2/0)2/19",
    "<X/@m<CJFl2R/@l/T/@l9EJFl<CJF",
    "E:/@mCE<EqCE5RA<2>q>5/+9X/+q5L/+3A2Cq155[15<Eq15D:3<GLq5DK$9XK$q>-K$A8GDqCED*CE<Em45<Eq4"
        "56V5I43q7#1K9X1Kq<V1K>/45q@C6Z@C<Eq@CC/>/ERq<VH<9XH<q7#H<5IETq45C345<E",
    "E:/@m<2/@l98/@l98C)q98E;9AG@q9+G*8JFLq8/F44;C0l2TE2l9OJFl<2JFl<2/@",
    "E:/@mC</@l13/@l132&l8,8Zq;4<+<4=@q=4>T=QA+q>4B;>4CWq>4F#=%G/q;OH<9AH<q7VH<6;GWq4[G83.EZl"
        "1GG[q50J[9>J[q=,J[@1I(qB6G/B6D%qB6AC@Y>*q>C;K:M7[l5$29l5$21lC<21lC</@",
    "E:/@mB=D=qB=AZA&@8q>I=P<(=1l<(=)q@0<LAN;)qC29@C26VqC23,@J1+q=(/+85/+q61/+4A/=q2Q/O1-0Cl1"
        "-38q2U2B4P2(q6L1I8;1Iq@.1I@.6Zq@.;L7M;Ll5,;Ll5,>2l7O>2q:R>2<F@Fq>9AZ>9D7q>9F2='G7q;OH<9A"
        "H<q7QH<63G[q4OGA2RF2l15H2q2XIB5$J1q7*J[9<J[q=1J[@7I0qB=G@B=D=",
    "E:/@mDJ5@l@Q5@l@Q/@l<Z/@l<Z5@l025@l028(l<IJNl@QJNl@Q8.lDJ8.lDJ5@m<Z8.l<ZAUq<ZD;=+GHl=#GH"
        "q<+EX;9DQl308.l<Z8.",
    "E:/@m9<@<q=D@<@X=9qC4;7C47QqC43N@L1<q=+/+8F/+q4./+1U0Cl1U3:q3*2F4[2+q6S1K8H1Kq;P1K=A3-q@"
        "24I@27=q@2<X8D<Xq6U<X4%<:l2@=9l3>JFlA=JFlA=GUl6$GUl57@%q7:@<9<@<",
    "E:/@m1E:Iq1EC74DG,q7DJ[=;J[q@<J[AFJHlAFH(q@0HB==HBq92HB7&EWq4SC44G<Kl4S<Kq6Q@O;&@Oq>D@OA"
        "E=HqCG;ACG7UqCG3QA91=q>-/+:9/+q66/+3Z2-q1E501E:Im:71Iq<V1I>331q@K4T@K7Uq@K:=>9;Yq=(=;:@="
        ";q8V=;7C<Oq6/<)5::Yq4G9P4G8Bq4G6K565)q6&3A772Eq8J1I:71I",
    "E:/@m4E/@l@:GUl1-GUl1-JFlCCJFlCCH0l7U/@l4E/@",
    "E:/@m9XJ[q=@J[@EI5qBJGIBJDMqBJBQA>A/q@3>G<I=5q@S;QB-:*qCA8=CA62qCA3$A11'q=[/+:%/+q5T/+3F"
        "0Zq172Q176,q17:H6R=+q47>B33A+q2/BO2/DOq2/GF44I3q6:J[9XJ[m436(q433Y5O2Nq721C9Z1Cq<G1C>)2Q"
        "q@E4&@E60q@E7Z>.94q<Q:I96;Xq6J:P5>99q438$436(m9VHDq7IHD69G@q5*F;5*DHq5*C#6-ARq70@H:'>=q<"
        "G@B=JAOq>NC#>NDHq>NF<=<G@q<,HD9VHD",
    "E:/@mC<>=qC</+6E/+q4A/+34/@l342&q4M1E6C1Eq:S1E=$40q@/6V@:<8l@.<8q>/:V<E:)q:Z968X96q5=963"
        ";;:q19=>19B.q19F23IHGq5YJ[9IJ[q<5J[>4IFqA4H1B8EGqC<C$C<>=m9IH<q7)H<5LFQq45E,45B0q45>I5F="
        "-q6V;L9A;Lq;+;L<@<8q=U=%>I>-q@<@5@<ADq@<C<>LE%q=[FG<IGBq;7H<9IH<",
    "90/@m2/19q2/2E2N3.q343R453Rq573R5X3.q6A2E6A19q6A005X/Fq56.[45.[q3:.[2Q/Bq2/0)2/19m2/B,q2"
        "/DD45DDq6ADD6AB,q6AA#5X@8q56>N45>Nq3:>N2Q@4q2/@U2/B,",
    "90/@m5N3Nl6$36q5C1C4J/.q3Q,R2T*Pl0G*Pq1),H1J/8q222)2@3Nl5N3Nm2*B,q2*DD41DDq6<DD6<B,q6<A#"
        "5T@8q52>N41>Nq3/>N2I@8q2*A#2*B,",
    "E:/@mCA3Rl17;7l17=)lCAFIlCAD#l4C<8lCA6AlCA3R",
    "E:/@m1G>Rl1GB2lC0B2lC0>Rl1G>Rm1G7Al1G9ZlC09ZlC07Al1G7A",
    "E:/@m176Al@6<6l17D#l17FIlCA=)lCA;7l173Rl176A",
    "@./@m4I6Kl4I7Iq4I9N54;(q5Y<<7K=Yq:*A#:NB%q;9C';9DBq;9F7:/G6q9&H66TH6q5<H64)H#q2OGJ1%FQl/"
        "[I/q37J[7%J[q:<J[<6I4q>0GG>0DDq>0C2=UB2q=BA3<T@9q<->A9X<Cq8*;$7B:#q6Z8[6Z73l6Z6Kl4I6Km3P"
        "19q3P3R5X3Rq6Z3R7A3.q8(2D8(19q8(017A/Fq6Y.[5X.[q5#.[49/Bq3P0)3P19",
    "Q8/@mO/<AqO/9[N;7UqMH5OL/4FqJP3<HX3<qG93<F648qE354E(6NlDY6NqD05.BV45qAD3<>N3<q<'3<:C52q9"
        "&7)9&:1q9&=V;,A,q=2C<AKC<qBWC<D<C/qE[C#G/BFlFO9/lFO8RqFO5HI+5HqJO5HKP7CqLQ9>LQ<CqLQ@PK>C"
        "/qJ,EHGLFYqE3H2B*H2q=+H2:.FFq71DZ5KAVq4+=S4+9Rq4+487$1<q9V.A@4.AqD&.AH(0&lH(-JqDI,-@4,-q"
        "8R,-50/Mq1I341I9Kq1I>63DBZq5>FE9$HDq<CJDB*JDqEZJDHYHYqKYG6MDD7qO/A9O/<Am;N:-q;N5H@05HqCX"
        "5HD1;0lD@@VqC/A1AKA1q>8A1=&>Hq;N=%;N:-",
    "GH/@mD@/@lA17Ql5P7Ql2D/@l/@/@l9RJLl<8JLlGH/@lD@/@m@4:Bl<2CGq;JE,;&G9q:IEJ9XCGl6T:Bl@4:B",
    "H./@m3(JFl:=JFq@IJFB[I&qE4G@E4D+qE4ARD#@4qBL=Q@0=7l@0=-qF-<,F-6XqF-3;CQ1=qA</@<./@l3(/@l"
        "3(JFm6*>;l;*>;q>6>;@N@;qB,A<B,CSqB,F%@EG#q>$G[:EG[l6*G[l6*>;m6*;Tl6*2(l;D2(q>M2(A534qBX4"
        "BBX7+qBX9DA3:Lq>I;T;5;Tl6*;T",
    "GD/@m>2H2q9ZH27=E9q4[BB4[<Cq4[7;784Gq9P1S>01SqAZ1SE=2RlE=0,qBN/+=O/+q8#/+4T2Hq1M6+1M<Eq1"
        "MAG30DIq4NGK7EI6q:<J[>4J[qC:J[F>I>lE.FUqB0H2>2H2",
    "K,/@mHX<QqHX66E:2WqAW/@:5/@l3(/@l3(JFl;(JFqB-JFECG0qHXCTHX<QmEL<KqELBQC+E9q@EG[:BG[l6*G["
        "l6*2*l9R2*q@12*B[4PqEL7=EL<K",
    "DS/@mBH/@l3(/@l3(JFlBHJFlBHGWl6*GWl6*>@lAY>@lAY;Rl6*;Rl6*2/lBH2/lBH/@",
    "C8/@m6*/@l3(/@l3(JFlBHJFlBHGWl6*GWl6*=7lAY=7lAY:Il6*:Il6*/@",
    "K*/@m>D=-lH<=-lH<0>qF8/RD0/>qB(/+>2/+q86/+5%2Iq1M6.1M<Cq1MAG37DJq5#GN8'I7q;+J[@2J[qD<J[H"
        "&I<lFUFOqC6H2@'H2q:4H27GE;q4YBE4Y<Cq4Y727A4Bq:)1Q@)1QqBR1QE:2;lE::=l>D:=l>D=-",
    "K>/@mGW/@lDU/@lDU;Pl6*;Pl6*/@l3(/@l3(JFl6*JFl6*>@lDU>@lDUJFlGWJFlGW/@",
    "9K/@m3(/@l3(JFl6*JFl6*/@l3(/@",
    "92/@m/3(Gq-F(G,H))l,H+Kq-W+6/3+6q1&+61Z,:q2V->2V/@l2VJFl5XJFl5X/Nq5X,74/*@q2@(G/3(G",
    "FY/@mFY/@lC8/@l8T<,l6*9Ml6*/@l3(/@l3(JFl6*JFl6*<IlBZJFlFCJFl;&>2lFY/@",
    "C>/@m3(/@l3(JFl6*JFl6*21lBH21lBH/@l3(/@",
    "QA/@m>H/@l5PGHl5HGHq5VDV5VA)l5V/@l3(/@l3(JFl7IJFl@X4'lA'4'lI:JFlMYJFlMY/@lJW/@lJWA5qJWD/"
        "K,GFlK$GFlB(/@l>H/@",
    "L'/@mH>/@lE$/@l5NF:l5FF:q5VBC5V>6l5V/@l3(/@l3(JFl6AJFlEN3PlEV3PqET42EM6UqEF9@EH:GlEHJFlH"
        ">JFlH>/@",
    "L[/@mJN<EqJN65GD2MqD:/+=O/+q8#/+4T2Iq1M6.1M<Gq1MD#4UG@q8$K$=QK$qD;K$GEG<qJNCUJN<Em4Y<Eq4"
        "Y737.4Bq9=1Q=O1QqC)1QE54BqGB72GB<EqGBBTE5EDqC*H4=QH4q9=H47.ECq4YBR4Y<E",
    "FA/@mDHC#qDH>%AX;Vq>09O9.9Ol6*9Ol6*/@l3(/@l3(JFl9TJFqDHJFDHC#m6*<8l8T<8q<V<8>K=JqA@>[A@B"
        "TqA@E<>QFLq=)G[9AG[l6*G[l6*<8",
    "L[/@mJN<EqJN7DHM41qFL0XC%/NlI1)3lDS)3l>N/-l=O/+q8#/+4T2Iq1M6.1M<Gq1MD#4UG@q8$K$=QK$qD;K$"
        "GEG<qJNCUJN<Em4Y<Eq4Y737.4Bq9=1Q=O1QqC)1QE54BqGB72GB<EqGBBTE5EDqC*H4=QH4q9=H47.ECq4YBR4Y"
        "<E",
    "G)/@m6*:7l6*/@l3(/@l3(JFl:1JFq@&JFB6HOqDHFXDHC0qDH=&>9;0lF>/@lBV/@l;D:7l6*:7m6*<Zl:3<Zq="
        "@<Z@#>0qA@@AA@C'qA@EI>ZFQq=<GY:'GYl6*GYl6*<Z",
    "DD/@mBR6<qBR3#@51'q<R/+8B/+q3V/+1906l1932q3#2E4V2.q6P1Q8H1Qq;J1Q=/2Yq>N4)>N6,q>N7A>.88q="
        "I91<89[q;):L8@;Hq4T<Y33>Mq1MAA1MD9q1MG:4#I.q62J[:#J[q=VJ[B,IClA/FWq<[H29XH2q7AH26,G0q4QF"
        ".4QD7q4QC#54B*q5QA26[@Bq8->R:G=Yq>M<>A2:QqBR9*BR6<",
    "DM/@m;*/@l8(/@l8(GWl/RGWl/RJFlD9JFlD9GWl;*GWl;*/@",
    "K*/@mGQJFlGQ8LqGQ41E)1KqB:/+<K/+q7[/+591Lq2R432R8Pl2RJFl5TJFl5T8Dq5T547H3Cq9;1Q<V1QqA.1Q"
        "B[3CqDO55DO8FlDOJFlGQJF",
    "F2/@mC#JFlF2JFl;T/@l8T/@l/@JFl2LJFl8L8Lq9N5Q:73&q;#5Y<%8RlC#JF",
    "R7/@mJU/@lGU/@lBFA[qB0C+AODWqA4FJA3G%q@VDJ@%AUl9X/@l6X/@l/[JFl3.JFl759>q8-6(8D36q9&6F:#9"
        "Ml>JJFlBVJFlGQ9EqHI6RI136qIE5UJB9AlNHJFlQTJFlJU/@",
    "EF/@mE=/@lB$/@l:#:[l2T/@l/H/@l85=+l00JFl3EJFl:'@2lAFJFlDSJFl;N=1lE=/@",
    "D[/@m9M<ClAKJFlD[JFl;29Gl;2/@l8./@l8.9>l/@JFl2RJFl9M<C",
    "E8/@mCW/@l0Z/@l0Z1Ul>RGUl19GUl19JFlCAJFlCAH0l4I21lCW21lCW/@",
    ";B/@m:G)Ll2=)Ll2=JFl:GJFl:GH(l5=H(l5=,1l:G,1l:G)L",
    "<X/@m2RJFl<E/@l9G/@l/WJFl2RJF",
    ";B/@m0:,1l5D,1l5DH(l0:H(l0:JFl8DJFl8D)Ll0:)Ll0:,1",
    "D5/@m0896l8*JQl9VJQlC:96l@K96l9&GHl3(96l0896",
    "@V/@m@Z)Ul/;)Ul/;,/l@Z,/l@Z)U",
    "EF/@m=BFIl;DFIq::GE8RI4q70K$6AL+l6ALAl:+LAq:LK3;MIIq<NH&=BG)l=BFI",
    "DS/@m>J/@l>(23l=Y23q<>0<;$/Pq9D/+79/+q4>/+2R0Hq1-2+1-4Wq1-:S:I;*l=[;0l=[<<q=[>N<[@Sq<#AY"
        "9RAYq78AY43@<l38BLq4RC@6BCYq82D9:#D9q=@D9@-BSqAUA3AU<TlAU/@l>J/@m7[1Eq:N1E<53)q=W4G=W77l"
        "=W9*l:Y9#q7:8U5S7Vq436X434Uq4332512;q601E7[1E",
    "FW/@m;ND9q@FD9BMANqDU>*DU94qDU4>BL1Qq@D/+;N/+q9S/+81/Sq6J0C5F2$l592$l4O/@l2H/@l2HL3l5FL3"
        "l5FEBq5FC25=A=l5FA=q7JD9;ND9m;5AWq83AW6Y@,q5F=;5F94q5F5-6[39q871G;91Gq>*1G@=3FqAQ5FAQ96q"
        "AQ=,@=@%q>*AW;5AW",
    "AW/@m:=/+q6//+3U1Nq1C481C9,q1C>'3WANq63D;:ID;q<'D;=>D*q>VCR@KC:l>P@Vq=QA3<HABq;>AQ:EAQq4"
        "GAQ4G9.q4G5E6'3Iq7B1M:91Mq<S1M@:2Pl@:0,q=</+:=/+",
    "FW/@m@Z2*l@Q2*q=N/+9I/+q5R/+3J1Oq1C491C90q1C>'3KANq5SD;9ID;q=HD;@OABlA#ABl@UBYl@QD5l@QL3"
        "lCOL3lCO/@lA7/@l@Z2*m:%1Gq='1G>;32q@Q4X@Q8Fl@Q90q@Q=9>:@,q=%AY:#AYq79AY6#>Wq4G<V4G9.q4G5"
        "<6#3Bq781G:%1G",
    "E$/@m:W/+q6D/+4&1Pq1C4;1C9*q1C=T3UAHq6/D;:+D;q=RD;@ZB#qC)>EC):GlC)8Nl4G8Nq4L54673Aq8$1M;"
        "$1Mq>-1MB23&lB20:q@K/M>3/<q<V/+:W/+m:)AYq7NAY66@:q4Y=U4K;,l>X;,q>X=Z=J@<q<;AY:)AY",
    ";V/@m;=AOl6>AOl6>/@l3A/@l3AAOl0$AOl0$C)l3AD-l3AE2q3AL>9RL>q;8L>==KTl<KI>q:[J%9OJ%q8(J%73"
        "HWq6>GQ6>E6l6>D'l;=D'l;=AO",
    "DB/@mCID'lCIB.l@%AOq@BA+@X@*qA5>*A5<TqA59[>782q<96C8Z6Cq8(6C756Kq5;5K5;4-q5;386(2[q6N2F8"
        "72Fl;R2Fq@#2FAK12qC:/XC:-8qC:**@Q(;q=.&L8.&Lq47&L22(+q0.)D0.,-q0.-Z16/2q2>0D4C1%q3Q18332"
        "(q2P2Q2P3Nq2P4R375Gq3X6;5,7-q3H7Q2J94q1M:Q1M<Mq1M@Y3IBJq5ED;9*D;q:ID;;VD'lCID'm3&,/q3&*G"
        "49)Qq5M([80([q;Z([=N*)q@C+/@C-*q@C.L>D/6q=E/Y:U/Yl75/Yq54/Y4-.[q3&.$3&,/m4I<Qq4I:N5R9Kq6"
        "[8H9&8Hq=98H=9<Tq=9B29#B2q6WB25PA+q4I@$4I<Q",
    "FY/@mA%/@lA%<,qA%>C>Y@Mq=TAW;BAWq8<AW7$@0q5F=C5F9Ml5F/@l2H/@l2HL3l5FL3l5FCUq5FB75=A7l5HA"
        "7q6ABO8*CDq9ND9;RD9q@:D9B.BJqD#@[D#<2lD#/@lA%/@",
    "8N/@m5F/@l2H/@l2HD'l5FD'l5F/@m29I8q29J92VJTq39K64+K6q4TK658JTq5VJ85VI8q5VH858GUq4TG94+G9"
        "q39G92VGUq29H829I8",
    "8N/@m02&Lq.D&L-A',l-A)Dq.N)//Y)/q16)/1[)[q2H*M2H,3l2HD'l5FD'l5F,@q5F&L02&Lm29I8q29J92VJT"
        "q39K64+K6q4TK658JTq5VJ85VI8q5VH858GUq4TG94+G9q39G92VGUq29H829I8",
    "CK/@m5D9Aq66:F7W<8l>0D'lBND'l9R:MlC4/@l>L/@l7Q8Nl5D6Rl5D/@l2H/@l2HL3l5DL3l5D<Cq5D;D5;9Al"
        "5D9A",
    "8N/@m5F/@l2H/@l2HL3l5FL3l5F/@",
    "RA/@mLE/@lLE<0qLE>DKE@MqJEAWH>AWqELAWD9@5qC'=MC':;lC'/@l@)/@l@)<0q@)>D>)@Mq=)AW:[AWq8.AW"
        "6V@0q5F=D5F9Ol5F/@l2H/@l2HD'l5&D'l5BA9l5JA9q6ABR8%CGq9DD;;=D;qA&D;B=A)lBFA)qC>BHE+CBqFQD"
        ";HXD;qL1D;MVBLqOCA$OC<2lOC/@lLE/@",
    "FY/@mA%/@lA%<,qA%>C>Y@Mq=TAW;BAWq8=AW7%@1q5F=E5F9Ol5F/@l2H/@l2HD'l5&D'l5BA9l5JA9q6EBS80C"
        "Gq9UD;;VD;q@;D;B/BLqD#A$D#<2lD#/@lA%/@",
    "FE/@mDB94qDB4AB*1Rq>L/+:=/+q7S/+5Q08q3O1F2I3Wq1C6/1C94q1C>(3YANq66D;:ED;q>KD;B)AKqDB=ZDB"
        "94m4G94q4G5C6*3Eq7G1G:B1Gq=<1G>Y3DqA=5BA=94qA==%>Y>Zq=<AW:@AWq7EAW6)@#q4G=(4G94",
    "FW/@m;N/+q9S/+81/Sq6J0C5F2$l592$q5F045F.Ol5F&Ll2H&Ll2HD'l5&D'l5=A9l5FA9q6NC#82CLq9PD;;ND"
        ";q@HD;BNAOqDU>)DU94qDU4>BL1Qq@D/+;N/+m;5AWq85AW6[@1q5H=E5F9Zl5F94q5F5-6[39q871G;91Gq=X1G"
        "@73JqAQ5MAQ96qAQ=#@7>Yq=XAW;5AW",
    "FW/@m:%1Gq=#1G>73/q@L4Q@Q8Dl@Q90q@Q=6>:@+q=$AY:#AYq79AY6#>Wq4G<V4G9.q4G5@5[3Cq771G:%1Gm9"
        "E/+q5Q/+3J1Qq1C4=1C90q1C>%3KAMq5SD;9ID;q=JD;@SA9lA#A9lA;D'lCOD'lCO&Ll@Q&Ll@Q/(q@Q0UA#2*l"
        "@O2*q=L/+9E/+",
    ">;/@m;DD;q<UD;=WD/l=@A=q<3AM;7AMq8[AM73>Qq5F<U5F:#l5F/@l2H/@l2HD'l5(D'l5;@<l5D@<q6IB78.C"
        "9q9MD;;DD;",
    "AY/@m@24Sq@22)=00Gq;./+7A/+q3G/+1<08l1<3*q2T2:4=2#q6(1E7E1Eq9W1E;,25q<:3'<:4Eq<:5M;:6Bq:"
        ";777C8=q4R9>3I:0q2A;#1Y;Zq19<X19>2q19AI36C%q53D;8JD;q;SD;>TC+l=Q@Mq:TAY8=AYq67AY53A3q4/@"
        "G4/>=q4/=J4F=*q5$<D5W<'q6Q;D96:Gq<R97>%8'q@26P@24S",
    "<:/@m8Z1Eq9N1E:>1Kq;/1R;H1Yl;H/Jq;,/<://4q93/+8B/+q2T/+2T5*l2TAOl0&AOl0&C.l2TD;l4)HFl5RH"
        "Fl5RD'l;@D'l;@AOl5RAOl5R51q5R3>6I2Bq7@1E8Z1E",
    "FY/@m5;D'l5;68q5;3[6A2Qq7F1G9X1Gq=#1G>:34q@S4[@S8Pl@SD'lCQD'lCQ/@lA7/@l@X2*l@O2*q>T0J=0/"
        "Wq;G/+9C/+q5[/+4.0Sq2;2B2;62l2;D'l5;D'",
    "BR/@m6X/@l/@D'l2JD'l6V7=q85398D2-l8L2-q8W3*9Y6(q;#9'>HD'lBRD'l:9/@l6X/@",
    "LY/@mCG/@l@%:[q>K<%=O@Ol=G@Oq<W<H<8:Yl8J/@l51/@l/WD'l3$D'q4W;K5V7Sq6V3[7%2Hl7-2Hq783I7Q5"
        "2q816V8D7Sl<,D'l@8D'lCU7SqDU4OE02JlE82JqE<35EN4IqF'6#I>D'lLCD'lG+/@lCG/@",
    "CI/@m779Al0CD'l3XD'l9(;Dl>0D'lBDD'l:O9AlBX/@l>D/@l9(7;l3C/@l0./@l779A",
    "BX/@m/BD'l2LD'l7#7Wq8:4(8N29l8V29q9*349T5@q:F7L>LD'lBVD'l9>,Pq80)>6C()q4V&L2=&Lq1)&L/P'$"
        "l/P)9q0O)-1[)-q5%)-66,Fl7;/9l/BD'",
    "AF/@m@,/@l0Z/@l0Z1Al;HAOl1GAOl1GD'l>VD'l>VAOl471Ql@,1Ql@,/@",
    "=7/@m7[/Lq7[-V9$-'q:',1<(,/l<()Lq8K)N6S+2q4[,P4[/Bl4[4Yq4[6Q3T7Eq2M890E89l0E:Wq2W:Y3Y;Oq"
        "4[<E4[>4l4[DOq4[GB6WI'q8SJF<(JFl<(H*q7[H$7[DDl7[>4q7[:=4#9Ol4#9Cq7[8T7[5$l7[/L",
    "DH/@m85L3l:SL3l:S&Hl85&Hl85L3",
    "=7/@m8R9Oq4S:=4S>4l4SDDq4SH$0PH*l0PJFq4'JF5YI&q7SG@7SDOl7S>4q7S<D8V;Nq9Y:Y<2:Wl<289q:(89"
        "8Z7Eq7S6Q7S4Yl7S/Bq7S,Q6#+3q4-)N0P)Ll0P,/q2O,13Q-'q4S-V4S/Ll4S5$q4S7&5R8*q6Q9.8R9Cl8R9O",
    "E:/@m5B<0q4E<03<;Gq25;%17:'l17<Oq3+>L5L>Lq6X>L7X>=q8Y>/:B=Bq;L=%<E<Pq==<C>4<Cq@2<CA:=*qB"
        "C=KCA>LlCA<%qAK:'>,:'q<U:';N:7q:G:I96;0q8#;Q7.<$q69<05B<0",
};

static const struct render_extra_outline {
    uint32_t character;
    const char *glyph;
} render_extra_outlines[] = {
    {0xB0,
        "@,/@m1OE:q1OGM38I7q5#J[75J[q9HJ[;2I7q<VGN<VE:q<VCW<,BGq;;A7:*@Fq8R>T75>Tq5#>T38A=q1OC'1O"
        "E:m3RE:q3RCY4TBXq5WAW77AWq8PAW9QBWq:SCX:SE:q:SFW9RGWq8RHX77HXq5UHX4SGWq3RFV3RE:"},
    {0xD7,
        "E:/@mA3E@lC#CMl;L<:lBZ6*lA147l9X:Gl3L47l1W6*l8,<:l1UCKl3IE@l9Z>,lA3E@"},
    {0x2212,
        "E:/@m17;,l17=GlCA=GlCA;,l17;,"},
};
/* clang-format on */
#endif
