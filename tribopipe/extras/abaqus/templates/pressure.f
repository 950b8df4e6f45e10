C
      SUBROUTINE TPPRES(NODE,P,JMATYP,JGVBLOCK)
C     Contact pressure P [MPa] at a node; 0 where it is not in contact.
      INCLUDE 'ABA_PARAM.INC'
      PARAMETER (MAXEL = 500, MAXARR = 15)
      DIMENSION JELEMLIST(MAXEL),JELEMTYPE(MAXEL),ARRAY(MAXARR)
      DIMENSION JMATYP(*),JGVBLOCK(*)
C
      P = 0.0D0
      NELEMS = MAXEL
      JRCD = 0
      CALL GETNODETOELEMCONN(NODE,NELEMS,JELEMLIST,JELEMTYPE,JRCD,
     *     JGVBLOCK)
      IF (JRCD.NE.0) THEN
        WRITE(7,*) 'UMESHMOTION: found no elements at node ',NODE
        CALL XIT
      END IF
      DO 10 I = 1,MAXARR
        ARRAY(I) = 0.0D0
   10 CONTINUE
${jtyp_value}C     The first component of CSTRESS is CPRESS. JRCD is 1 where all of
C     them are zero.
      CALL GETVRMAVGATNODE(NODE,${jtyp_argument}'CSTRESS',ARRAY,JRCD,
     *     JELEMLIST,NELEMS,JMATYP,JGVBLOCK)
      IF (JRCD.EQ.0) P = MAX(ARRAY(1),0.0D0)
      RETURN
      END
